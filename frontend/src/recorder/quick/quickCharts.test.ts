import { expect, test } from "vitest";
import type { Quick } from "../../api/types";
import { comparedCharts, folded, joined, nearest, quickCharts } from "./quickCharts";

function quickOf(start: number): Quick {
  const t = Array.from({ length: 400 }, (_, i) => i * 0.05);
  const signal = (key: string, unit: string, values: (number | null)[]) => {
    const [field, index] = key.split(".");
    return { key, field, index: index === "norm" ? null : Number(index), label: key, unit, values };
  };
  const x = t.map((at) => 0.2 + 0.01 * Math.cos((2 * Math.PI * (at - start)) / 4));
  const signals = [
    signal("p_ref.0", "m", x),
    signal("p_meas.0", "m", x),
    signal(
      "u.0",
      "N m",
      t.map(() => null),
    ),
  ];
  return {
    t,
    duration: 20,
    rows: 400,
    signals,
    track_t: [],
    tracks: [],
    period: 4,
    cycle_start: start,
    cycle_end: 20,
  };
}

test("plots are in display units, and what a recording does not hold is left out", () => {
  const charts = quickCharts(quickOf(0));
  expect(charts.map(({ title, unit }) => [title, unit])).toEqual([["Tip x", "mm"]]);
  expect(charts[0].columns[1][0]).toBeCloseTo(210, 9);
  expect(charts[0].lines.map(({ look }) => look)).toEqual(["dashed", "dots"]);
});

test("on common phase the same motion begun at another time is the same line", () => {
  const values = (quick: Quick) => quick.signals[0].values;
  const [first, second] = [quickOf(0), quickOf(1.3)].map((quick) => folded(quick, values(quick))[1]);
  first.forEach((value, i) => {
    if (value !== null && second[i] !== null) expect(Math.abs(value - second[i])).toBeLessThan(1e-3);
  });
  expect(folded({ ...quickOf(0), period: null }, [1])[1].every((value) => value === null)).toBe(true);
});

test("runs on common time share one x, each with its own points only", () => {
  const [x, a, b] = joined([
    [
      [0, 2],
      [1, 3],
    ],
    [
      [1, 2],
      [5, null],
    ],
  ]);
  expect(x).toEqual([0, 1, 2]);
  expect([a[0], a[1], a[2]]).toEqual([1, undefined, 3]);
  expect([b[0], b[1], b[2]]).toEqual([undefined, 5, null]);
  const runs = [quickOf(0), quickOf(1)].map((quick) => ({ quick }));
  const [chart] = comparedCharts(runs, "time");
  expect(chart.lines.map(({ label }) => label)).toEqual(["1", "2"]);
  expect(chart.lines[0].dash).not.toEqual(chart.lines[1].dash);
});

test("the nearest time is found, at both ends too", () => {
  expect([-1, 0.4, 0.6, 9].map((at) => nearest([0, 1, 2], at))).toEqual([0, 0, 1, 2]);
  expect(nearest([], 1)).toBe(-1);
});
