import { expect, test } from "vitest";
import type { Person } from "../api/types";
import { keep, operatorText, withLines } from "./page";

test("a status that repeats itself keeps its object, so that controls do not render", () => {
  const old = { K_P: [1, 2] };
  expect(keep(old, { K_P: [1, 2] })).toBe(old);
  expect(keep(old, { K_P: [1, 3] })).not.toBe(old);
});

test("a log that is told again adds only what was missed, newest first", () => {
  const event = (time: string, text: string) => ({ type: "event", level: "info", time, text, subject: "", count: 1 }) as const; // prettier-ignore
  const first = event("2026-01-01T10:00:00.100000Z", "arm");
  const local = event("2026-01-01T10:00:01.000Z", "no answer");
  const later = event("2026-01-01T10:00:02.500000Z", "hold");
  const log = withLines(withLines([], [first]), [local]);
  const told = withLines(log, [first, later]);
  expect(told.map(({ text }) => text)).toEqual(["hold", "no answer", "arm"]);
  expect(withLines(told, [first, later])).toBe(told);
});

test("an alarm that comes again counts up in one line, and one that is over long since stays", () => {
  const alarm = (second: number, count: number) =>
    ({ type: "event", level: "warning", time: `2026-01-01T10:00:${second}Z`, text: `late ${second}`, subject: "alarm late", count }) as const; // prettier-ignore
  const arm = { ...alarm(12, 1), text: "arm", subject: "" };
  let log = withLines([], [alarm(10, 1), alarm(11, 2), arm]);
  log = withLines(log, [alarm(13, 3)]);
  expect(log.map(({ text, count }) => [text, count])).toEqual([["late 13", 3], ["arm", 1]]); // prettier-ignore
  expect(withLines(log, [alarm(50, 1)]).map(({ text }) => text)).toEqual(["late 50", "late 13", "arm"]);
});

test("who has closed the page is not said to operate", () => {
  const lease = { held: true, mine: false, holder: "ivy 3", clutch: false, lost: "" };
  const ivy: Person = { tag: "0123456789ab", name: "ivy 3", role: "operator" };
  const people = { holder: ivy.tag, asking: [], others: [ivy], waiting: false };
  expect(operatorText({ lease, people })).toBe("ivy 3 operates");
  expect(operatorText({ lease, people: { ...people, others: [] } })).toContain("has closed the page");
});
