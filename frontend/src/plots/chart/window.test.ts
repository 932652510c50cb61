import { expect, test } from "vitest";
import type { PlotBins } from "../../api/socket";
import { Ring } from "../../live/ring";
import { digitsFor, niceStep, numberLabels, plainTicks, secondsTicks, timeLabel, type Tick } from "./axes";
import { withoutCommonStart } from "./readout";
import { counted, FOLLOWING, zoomed } from "./view";
import { emptyData, extractWindow, niceRange } from "./window";

type Wave = (t: number) => number;

/** Bins of channel 0 at these times, numbered by their times. */
function bins(times: readonly number[], low: Wave, high = low): PlotBins {
  return {
    first: Math.round(times[0]),
    channels: Uint32Array.of(0),
    t: Float64Array.from(times),
    low: Float32Array.from(times, low),
    high: Float32Array.from(times, high),
  };
}

function ringOf(capacity: number): Ring {
  const ring = new Ring(capacity);
  ring.choose([0]);
  return ring;
}

const range = (from: number, to: number) => Array.from({ length: to - from }, (_, i) => from + i);
const timesOf = (ring: Ring) => range(0, ring.length).map((bin) => ring.time(bin));
const lowsOf = (ring: Ring, channel: number) =>
  range(0, ring.length).map((bin) => ring.extremes(channel, bin, bin + 1)[0]);

test("the ring keeps the newest bins and forgets the oldest", () => {
  const ring = ringOf(8);
  ring.push(bins(range(0, 20), (t) => 10 * t));
  expect(ring.length).toBe(8);
  expect([ring.time(0), ring.newest]).toEqual([12, 19]);
  expect(ring.extremes(0, 7, 8)).toEqual([190, 190]);
});

test("history that is sent again after a reconnection is not stored twice", () => {
  const ring = ringOf(100);
  ring.push(bins(range(0, 10), (t) => t));
  ring.reconnect();
  ring.push({ ...bins(range(5, 12), (t) => t), first: 905 });
  expect(timesOf(ring)).toEqual(range(0, 12));
  ring.push({ ...bins(range(12, 14), (t) => t), first: 912 });
  expect(lowsOf(ring, 0)).toEqual(range(0, 14));
});

test("a reconnection that brings nothing new leaves everything in its place", () => {
  const ring = ringOf(100);
  ring.push(bins(range(0, 10), (t) => t));
  ring.reconnect();
  ring.push({ ...bins([8, 9], (t) => t), first: 0 });
  expect(lowsOf(ring, 0)).toEqual(range(0, 10));
});

test("the past of a channel that is chosen later comes later, and lands in its place", () => {
  const ring = ringOf(8);
  ring.push(bins(range(0, 10), (t) => t));
  ring.choose([0, 4]);
  expect(ring.since).toBeNull();
  ring.push({ ...bins(range(0, 10), (t) => -t), channels: Uint32Array.of(4) });
  ring.push({
    ...bins([10], () => 0),
    channels: Uint32Array.of(4, 0),
    low: Float32Array.of(-10, 10),
    high: Float32Array.of(-10, 10),
  });
  expect(lowsOf(ring, 0)).toEqual(range(3, 11));
  expect(lowsOf(ring, 4)).toEqual(range(3, 11).map((t) => -t));
  expect(ring.since).toBe(10);
});

test("a page whose channels changed while it was offline begins again", () => {
  const ring = ringOf(10);
  ring.push(bins(range(0, 5), (t) => t));
  ring.choose([0, 1]);
  ring.reconnect();
  ring.push(bins(range(200, 203), (t) => t));
  expect(timesOf(ring)).toEqual([200, 201, 202]);
});

test("the past comes after the present, piece by piece backwards, until the ring is full", () => {
  const ring = ringOf(10);
  ring.push(bins(range(100, 104), (t) => t));
  ring.push(bins(range(97, 100), (t) => t));
  ring.push(bins([104], (t) => t));
  expect(timesOf(ring)).toEqual(range(97, 105));
  ring.push(bins(range(90, 97), (t) => t));
  expect(timesOf(ring)).toEqual(range(95, 105));
  expect(lowsOf(ring, 0)).toEqual(range(95, 105));
  ring.push(bins([105], (t) => t));
  expect(lowsOf(ring, 0)).toEqual(range(96, 106));
});

test("a channel that is no longer chosen is dropped, and one that no one chose is not kept", () => {
  const ring = ringOf(8);
  ring.push(bins([1, 2], (t) => t));
  ring.choose([1]);
  ring.push(bins([3], (t) => t));
  expect(ring.extremes(0, 0, 3)).toEqual([Infinity, -Infinity]);
  expect(ring.length).toBe(3);
});

test("the ring begins again with the rig, whatever its clock says", () => {
  const ring = ringOf(8);
  ring.push(bins(range(100, 105), (t) => t));
  ring.clear();
  expect([ring.length, ring.newest]).toEqual([0, NaN]);
  ring.push({ ...bins([1, 2], (t) => t), first: 105 });
  expect(timesOf(ring)).toEqual([1, 2]);
});

test("bins that never came leave a gap in time only", () => {
  const ring = ringOf(100);
  ring.push(bins(range(0, 3), (t) => t));
  ring.push(bins(range(50, 53), (t) => t));
  expect(timesOf(ring)).toEqual([0, 1, 2, 50, 51, 52]);
  expect(lowsOf(ring, 0)).toEqual([0, 1, 2, 50, 51, 52]);
});

test("indexAt finds the first bin at or after a time, across the wrap", () => {
  const ring = ringOf(8);
  ring.push(bins(range(0, 13), (t) => t));
  expect([ring.indexAt(-1), ring.indexAt(7), ring.indexAt(7.5), ring.indexAt(99)]).toEqual([0, 2, 3, 8]);
});

test("one spike among a thousand bins stays visible in a narrow window", () => {
  const ring = ringOf(2000);
  const spike = (t: number) => (t === 500 ? 7 : 0);
  ring.push(bins(range(0, 1000), (t) => -spike(t), spike));
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 999, origin: 999, columns: 50 }, 1000, data);
  expect(data.x.length).toBeLessThanOrEqual(104);
  expect(data.series[0]).toContain(7000);
  expect(data.series[0]).toContain(-7000);
});

test("columns stand still on the time axis while the window scrolls", () => {
  const ring = ringOf(2000);
  ring.push(bins(range(0, 1000), (t) => Math.sin(t)));
  const [first, second] = [emptyData(1), emptyData(1)];
  extractWindow(ring, [0], { from: 100, to: 600, origin: 600, columns: 50 }, 1, first);
  extractWindow(ring, [0], { from: 103, to: 603, origin: 603, columns: 50 }, 1, second);
  const absolute = (data: typeof first, to: number) => data.x.map((x) => Math.round((x + to) * 1e6));
  expect(absolute(second, 603).slice(4, 80)).toEqual(absolute(first, 600).slice(4, 80));
  expect(second.series[0].slice(4, 80)).toEqual(first.series[0].slice(4, 80));
});

test("a falling ramp falls at every sample", () => {
  const ring = ringOf(200);
  ring.push(
    bins(
      range(0, 100),
      (t) => -t,
      (t) => -t + 0.5,
    ),
  );
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 99, origin: 99, columns: 20 }, 1, data);
  const y = data.series[0].slice(2).map((value) => value ?? NaN);
  expect(y.every((value, i) => i === 0 || value <= y[i - 1])).toBe(true);
});

test("a missing value is a gap, never zero", () => {
  const ring = ringOf(100);
  ring.push(bins(range(0, 40), (t) => (t < 20 ? NaN : 1)));
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 39, origin: 39, columns: 10 }, 1, data);
  expect(data.series[0].at(0)).toBeNull();
  expect(data.series[0].at(-1)).toBe(1);
});

test("time without bins is a gap, not a line across it", () => {
  const ring = ringOf(100);
  ring.push(bins(range(0, 20), (t) => t));
  ring.push({ ...bins(range(50, 60), (t) => t), first: 20 });
  const data = emptyData(1);
  extractWindow(ring, [0], { from: 0, to: 59, origin: 59, columns: 59 }, 1, data);
  expect(data.series[0].filter((y) => y === null)).toHaveLength(2);
  expect(data.x.every((x, i) => i === 0 || x > data.x[i - 1])).toBe(true);
  expect(data.x.length % 2).toBe(0);
});

test("the y axis has round limits around the data and a least height", () => {
  expect(niceRange({ x: [0], series: [[3.2, null, 9.7]] }, 4, false)).toEqual([2, 10]);
  expect(niceRange({ x: [], series: [[]] }, 4, true)).toEqual([0, 4]);
  expect([0.3, 1, 1.4, 6].map(niceStep)).toEqual([0.5, 1, 2, 10]);
});

const textsOf = (ticks: readonly Tick[]) => ticks.map(({ text }) => text);

test("the last mark of an axis carries the unit, and long times are minutes", () => {
  expect(textsOf(secondsTicks({ from: -10, to: 0 }, 100))).toEqual(["-10", "-5", "0 s"]);
  expect(textsOf(secondsTicks({ from: -600, to: 0 }, 80))).toEqual(["-10:00", "-5:00", "0 s"]);
  expect(textsOf(plainTicks("cycle")({ from: 0, to: 1 }, 100))).toEqual(["0", "0.5", "1 cycle"]);
  expect(timeLabel(-200, 1)).toBe("-3:20");
  expect(numberLabels([0, 2e-7, 1.5])).toEqual(["0", "2e-7", "1.5"]);
});

test("marks of an axis are on round times, as near as their labels allow", () => {
  const ticks = secondsTicks({ from: -7.3, to: -2.1 }, 360);
  expect(ticks.map(({ at }) => at)).toEqual([-7, -6.5, -6, -5.5, -5, -4.5, -4, -3.5, -3, -2.5]);
  expect(secondsTicks({ from: -7.3, to: -2.1 }, 0)).toEqual([]);
  const off = 1e-9; // a picture that runs is a rounding error away from the axis below it, and has the same marks
  expect(textsOf(secondsTicks({ from: -10 + off, to: off }, 340))).toEqual(
    textsOf(secondsTicks({ from: -10, to: 0 }, 340)),
  );
});

test("the time axis stands still while the picture runs, and goes with a zoom", () => {
  expect(counted(FOLLOWING, 10)).toEqual({ from: -10, to: 0 });
  const now = { newest: 100, seconds: 10 };
  expect(counted(zoomed(FOLLOWING, { from: 94, to: 96 }, now), 10)).toEqual({ from: -6, to: -4 });
});

test("a readout leaves out the words that all its names begin with", () => {
  expect(withoutCommonStart(["pressure u1+", "pressure command u1+"])).toEqual(["u1+", "command u1+"]);
  expect(withoutCommonStart(["measured tip", "reference"])).toEqual(["measured tip", "reference"]);
  expect([withoutCommonStart(["lateness time"]), withoutCommonStart([])]).toEqual([["lateness time"], []]);
});

test("a readout has the digits that its axis can show", () => {
  expect([digitsFor([0, 200]), digitsFor([-5, 5]), digitsFor([0, 0.01]), digitsFor([0, 1e6])]).toEqual([
    0, 1, 4, 0,
  ]);
});
