import { expect, test } from "vitest";
import type uPlot from "uplot";
import { cutTo, liveMarks, markAt } from "./marks";

/** A plot of 100 px a second whose area begins at 0. */
const plot = { valToPos: (value: number) => 100 * value } as unknown as uPlot;

test("bookmarks stand on the rig's clock, by their label or their number", () => {
  const bookmarks = [
    { n: 1, tick: 500, t: 0.5, label: "" },
    { n: 2, tick: 900, t: 0.9, label: "touched" },
  ];
  const marks = liveMarks({ origin: 1000, bookmarks });
  expect(marks).toEqual([
    { at: 1000.5, text: "1" },
    { at: 1000.9, text: "touched" },
  ]);
});

test("a click hits the nearest line within 6 px, and no other", () => {
  const marks = [
    { at: 1001, text: "1" },
    { at: 1001.08, text: "2" },
  ];
  expect(markAt(plot, marks, 105, 1000)?.text).toBe("2");
  expect(markAt(plot, marks, 94, 1000)?.text).toBe("1");
  expect(markAt(plot, marks, 93, 1000)).toBeNull();
});

test("a label ends before the next line, with dots where it is cut", () => {
  const tenEach = (text: string) => 10 * text.length;
  expect(cutTo(60, "marked", tenEach)).toBe("marked");
  expect(cutTo(59, "marked", tenEach)).toBe("mark…");
  expect(cutTo(60, "at two", (text) => 11 * text.length)).toBe("at t…");
  expect(cutTo(19, "marked", tenEach)).toBe("");
});
