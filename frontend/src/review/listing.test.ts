import { expect, test } from "vitest";
import type { Recording } from "../api/types";
import { badgesOf, listed, NEWEST, nextOrder } from "./listing";

const base = {
  id: "",
  name: "",
  started: "2026-11-21T12:00:00Z",
  actuator: "P1",
  operator: "",
  reference: "",
  notes: "",
  tags: [] as string[],
  gaps: 0,
  restarts: [],
  part_of: "",
  complete: true,
  metrics: null,
} as unknown as Recording;
const rows: Recording[] = [
  { ...base, id: "a", name: "Circle", tags: ["slow"], metrics: { rmse: 2 } as Recording["metrics"] },
  { ...base, id: "b", name: "square", notes: "slow pump", started: "2026-11-22T12:00:00Z" },
  { ...base, id: "c", name: "Bird", metrics: { rmse: 1 } as Recording["metrics"] },
];
const ids = (found: readonly Recording[]) => found.map(({ id }) => id).join("");

test("every word must be found somewhere: name, tags, notes", () => {
  expect(ids(listed(rows, "SLOW", NEWEST))).toBe("ba");
  expect(ids(listed(rows, "slow circ", NEWEST))).toBe("a");
  expect(listed(rows, "slow bird", NEWEST)).toEqual([]);
});

test("columns sort both ways, and what has no value comes last", () => {
  expect(ids(listed(rows, "", { column: "rmse", falling: false }))).toBe("cab");
  expect(ids(listed(rows, "", { column: "rmse", falling: true }))).toBe("acb");
  expect(ids(listed(rows, "", { column: "name", falling: false }))).toBe("cab");
  expect(nextOrder(nextOrder(NEWEST, "name"), "name")).toEqual({ column: "name", falling: true });
});

test("badges say what is wrong or special", () => {
  expect(badgesOf(rows[0], false)).toEqual([]);
  expect(badgesOf({ ...rows[0], complete: false }, true)).toEqual(["recording now"]);
  expect(badgesOf({ ...rows[0], complete: false, gaps: 3 }, false)).toEqual(["cut short", "3 ticks missing"]);
  expect(badgesOf({ ...rows[0], complete: false, recovered: true }, false)).toEqual(["recovered"]);
  expect(badgesOf({ ...rows[0], restarts: [{ after: 7, seconds: 1.5 }] }, false)).toEqual(["rig restarted"]);
});
