import { expect, test } from "vitest";
import type uPlot from "uplot";
import { liveMarks, markAt } from "./marks";

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
