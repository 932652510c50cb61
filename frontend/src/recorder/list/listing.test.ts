import { expect, test } from "vitest";
import type { Recording } from "../../api/types";
import { isSettled, marksOf, NEWEST, nextOrder, sortOf, whenText } from "./listing";

const base = {
  id: "",
  name: "",
  started: "2026-11-21T12:00:00Z",
  actuator: "P1",
  operator: "",
  reference: "",
  notes: "",
  tags: [] as string[],
  seconds: 20,
  gaps: 0,
  holes: [],
  restarts: [],
  bookmarks: [],
  problem: "",
  profile: "standard",
  part_of: "",
  imported: false,
  recovered: false,
  complete: true,
  metrics: null,
} as unknown as Recording;
test("columns sort both ways, words rise first and the newest stands first", () => {
  expect(sortOf(NEWEST)).toBe("-started");
  expect(nextOrder(NEWEST, "name")).toEqual({ column: "name", falling: false });
  expect(nextOrder(nextOrder(NEWEST, "name"), "name")).toEqual({ column: "name", falling: true });
  expect(sortOf(nextOrder(NEWEST, "rmse"))).toBe("-rmse");
});

test("badges say what is wrong or special, and why", () => {
  const texts = (row: Recording, running: boolean) => marksOf(row, running).map(({ text }) => text);
  expect(texts(base, false)).toEqual([]);
  expect(texts({ ...base, complete: false }, true)).toEqual(["recording now"]);
  const holes = [{ after: 41, ticks: 3 }];
  expect(texts({ ...base, complete: false, gaps: 3, holes }, false)).toEqual([
    "cut short",
    "3 ticks missing",
  ]);
  expect(texts({ ...base, complete: false, recovered: true }, false)).toEqual(["recovered"]);
  expect(marksOf({ ...base, gaps: 3, holes }, false)).toEqual([
    { text: "3 ticks missing", reason: "3 ticks are not in the file: 3 after tick 41.", bad: true },
  ]);
  expect(texts({ ...base, restarts: [{ after: 7, seconds: 1.5 }] }, false)).toEqual(["rig restarted"]);
  const damaged = { ...base, complete: false, problem: "its data is missing" };
  expect(marksOf(damaged, false)).toEqual([{ text: "problem", reason: "its data is missing", bad: true }]);
});

test("a recording is settled once its figures are there, or no one will take them", () => {
  const end = Date.parse(base.started) + 1e3 * base.seconds;
  expect(isSettled(base, end + 1000)).toBe(false);
  expect(isSettled(base, end + 3600e3)).toBe(true);
  expect(isSettled({ ...base, imported: true }, end)).toBe(true);
  expect(isSettled({ ...base, metrics: {} as Recording["metrics"] }, end)).toBe(true);
});

test("times are said as people say them, by local midnight", () => {
  const now = new Date(2026, 10, 24, 0, 30);
  const said = (...at: [number, number, number, number, number]) =>
    whenText(new Date(...at).toISOString(), now);
  expect(said(2026, 10, 24, 0, 5)).toBe("Today 00:05");
  expect(said(2026, 10, 23, 23, 59)).toBe("Yesterday 23:59");
  expect(said(2026, 2, 9, 8, 7)).toBe("9 Mar 08:07");
  expect(said(2025, 11, 31, 20, 44)).toBe("31 Dec 2025 20:44");
});
