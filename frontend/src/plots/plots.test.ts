import { expect, test } from "vitest";
import type { PlotBins } from "../api/binary";
import { Ring } from "./ring";
import { emptyData, extractWindow, niceRange, niceStep } from "./window";

function bins(times: readonly number[], low: (t: number) => number, high = low): PlotBins {
  return {
    t: Float64Array.from(times),
    low: Float32Array.from(times, low),
    high: Float32Array.from(times, high),
  };
}

const range = (from: number, to: number) => Array.from({ length: to - from }, (_, i) => from + i);

test("the ring keeps the newest bins and forgets the oldest", () => {
  const ring = new Ring(1, 8);
  ring.push(bins(range(0, 20), (t) => 10 * t));
  expect(ring.length).toBe(8);
  expect([ring.time(0), ring.newest]).toEqual([12, 19]);
  expect(ring.lowest(7, 0)).toBe(190);
});

test("history that is sent again after a reconnection is not stored twice", () => {
  const ring = new Ring(1, 100);
  ring.push(bins(range(0, 10), (t) => t));
  ring.push(bins(range(5, 12), (t) => t));
  expect(range(0, ring.length).map((bin) => ring.time(bin))).toEqual(range(0, 12));
});

test("bins of another number of channels are not stored", () => {
  const ring = new Ring(2, 8);
  ring.push(bins([1, 2], (t) => t));
  expect(ring.length).toBe(0);
});

test("indexAt finds the first bin at or after a time, across the wrap", () => {
  const ring = new Ring(1, 8);
  ring.push(bins(range(0, 13), (t) => t));
  expect([ring.indexAt(-1), ring.indexAt(7), ring.indexAt(7.5), ring.indexAt(99)]).toEqual([0, 2, 3, 8]);
});

test("one spike among a thousand bins stays visible in a narrow window", () => {
  const ring = new Ring(1, 2000);
  const spike = (t: number) => (t === 500 ? 7 : 0);
  ring.push(bins(range(0, 1000), (t) => -spike(t), spike));
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 999, columns: 50 }, 1000, data);
  expect(data.x.length).toBeLessThanOrEqual(104);
  expect(data.series[0]).toContain(7000);
  expect(data.series[0]).toContain(-7000);
});

test("columns stand still on the time axis while the window scrolls", () => {
  const ring = new Ring(1, 2000);
  ring.push(bins(range(0, 1000), (t) => Math.sin(t)));
  const [first, second] = [emptyData(1), emptyData(1)];
  extractWindow(ring, [0], { from: 100, to: 600, columns: 50 }, 1, first);
  extractWindow(ring, [0], { from: 103, to: 603, columns: 50 }, 1, second);
  const absolute = (data: typeof first, to: number) => data.x.map((x) => Math.round((x + to) * 1e6));
  expect(absolute(second, 603).slice(4, 80)).toEqual(absolute(first, 600).slice(4, 80));
  expect(second.series[0].slice(4, 80)).toEqual(first.series[0].slice(4, 80));
});

test("a falling ramp falls at every sample", () => {
  const ring = new Ring(1, 200);
  ring.push(
    bins(
      range(0, 100),
      (t) => -t,
      (t) => -t + 0.5,
    ),
  );
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 99, columns: 20 }, 1, data);
  const y = data.series[0].slice(2).map((value) => value ?? NaN);
  expect(y.every((value, i) => i === 0 || value <= y[i - 1])).toBe(true);
});

test("a missing value is a gap, never zero", () => {
  const ring = new Ring(1, 100);
  ring.push(bins(range(0, 40), (t) => (t < 20 ? NaN : 1)));
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 39, columns: 10 }, 1, data);
  expect(data.series[0].at(0)).toBeNull();
  expect(data.series[0].at(-1)).toBe(1);
});

test("the y axis has round limits around the data and a least height", () => {
  expect(niceRange({ x: [0], series: [[3.2, null, 9.7]] }, 4, false)).toEqual([2, 10]);
  expect(niceRange({ x: [], series: [[]] }, 4, true)).toEqual([0, 4]);
  expect([0.3, 1, 1.4, 6].map(niceStep)).toEqual([0.5, 1, 2, 10]);
});
