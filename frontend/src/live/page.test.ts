import { expect, test } from "vitest";
import { keep, withLines } from "./page";

test("a status that repeats itself keeps its object, so that controls do not render", () => {
  const old = { K_P: [1, 2] };
  expect(keep(old, { K_P: [1, 2] })).toBe(old);
  expect(keep(old, { K_P: [1, 3] })).not.toBe(old);
});

test("a log that is told anew adds only what was missed, newest first", () => {
  const event = (time: string, text: string) => ({ type: "event", level: "info", time, text }) as const;
  const first = event("2026-01-01T10:00:00.100000Z", "arm");
  const local = event("2026-01-01T10:00:01.000Z", "no answer");
  const later = event("2026-01-01T10:00:02.500000Z", "hold");
  const log = withLines(withLines([], [first]), [local]);
  const told = withLines(log, [first, later]);
  expect(told.map(({ text }) => text)).toEqual(["hold", "no answer", "arm"]);
  expect(withLines(told, [first, later])).toBe(told);
});
