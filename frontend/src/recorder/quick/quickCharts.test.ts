import { expect, test } from "vitest";
import type { Quick } from "../../api/types";
import { runClock, runWindow, type Stretch } from "./course";
import { comparedPaths } from "./paths";
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
    stretches: [{ kind: "run", start: 0, end: 20 }],
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

/** A circle of 4 s after `before` seconds at rest and 2 s of approach, held after `leg` seconds for `pause` seconds. */
function runOf(before: number, leg: number, pause: number): Quick {
  const begin = before + 2;
  const stretches: Stretch[] = [
    { kind: "before", start: 0, end: before },
    { kind: "approach", start: before, end: begin },
    { kind: "run", start: begin, end: begin + leg },
    { kind: "pause", start: begin + leg, end: begin + leg + pause },
    { kind: "run", start: begin + leg + pause, end: begin + 16 + pause },
  ];
  const clock = runClock(stretches);
  const t = Array.from({ length: 1600 }, (_, i) => i * 0.02);
  const turn = (at: number) => (2 * Math.PI * (clock(at) ?? 0)) / 4;
  const x = t.map((at) => (clock(at) === null ? 0.25 : 0.2 + 0.01 * Math.cos(turn(at))));
  const y = t.map((at) => (clock(at) === null ? 0 : 0.01 * Math.sin(turn(at))));
  const signal = { key: "p_meas.0", field: "p_meas", index: 0, label: "measured x", unit: "m", values: x };
  return {
    ...quickOf(0),
    t,
    stretches,
    signals: [signal],
    track_t: t,
    tracks: [{ field: "p_meas", x, y }],
    cycle_start: begin + 1,
    cycle_end: begin + 16 + pause,
  };
}

test.each(["time", "phase"] as const)(
  "runs of one path are one line on common %s, whatever was before them and however they were paused",
  (common) => {
    const runs = [runOf(1, 9.3, 0), runOf(7.4, 5.1, 3.7)].map((quick) => ({ quick }));
    const [{ columns }] = comparedCharts(runs, common);
    const [x, ...lines] = columns;
    const [first, second] = lines.map((line) =>
      x.flatMap((at, i) => (line[i] == null ? [] : [[at, line[i]]])),
    );
    expect(first[0][0]).toBeCloseTo(common === "time" ? 0 : 0.005, 1);
    expect(first.length).toBeGreaterThan(90);
    for (const [at, value] of first) {
      const other =
        second[
          nearest(
            second.map(([time]) => time),
            at,
          )
        ];
      expect(Math.abs(other[0] - at)).toBeLessThan(0.021);
      expect(Math.abs(other[1] - value)).toBeLessThan(0.4); // 10 mm of radius; where the line is not aligned: 20 mm
    }
  },
);

test("paths that are compared hold the last lap of the run, at the times of its clock", () => {
  const [path] = comparedPaths([{ quick: runOf(7.4, 5.1, 3.7) }]);
  expect([path.t[0], path.t.at(-1)].map((t) => Math.round(t ?? NaN))).toEqual([0, 16]);
  const shown = path.points.slice(...path.part);
  expect(shown.every((point) => point && Math.abs(Math.hypot(point[0] - 0.2, point[1]) - 0.01) < 1e-9)).toBe(
    true,
  );
  expect(shown.length).toBeGreaterThan(150);
});

test("a run's clock stands still where it is not followed, and its window leaves out what is around it", () => {
  const { stretches } = runOf(7.4, 5.1, 3.7);
  const clock = runClock(stretches);
  expect([0, 9, 15, 17].map(clock)).toEqual([null, null, null, null]);
  expect(clock(9.4)).toBeCloseTo(0, 9);
  expect(clock(18.2)).toBeCloseTo(5.1, 9);
  expect(runWindow(stretches)?.from).toBeCloseTo(9.4 - 0.04 * 19.7, 9);
  expect(runWindow(stretches)?.to).toBeCloseTo(29.1, 9);
  expect(runWindow([{ kind: "run", start: 0, end: 4 }])).toBeNull();
});
