import { plain } from "../../ui/format";
import type { Range } from "./view";

/** Left of a plot's area are the labels of its y axis, right of it half of the last label of time [px]. */
export const SIDES = { left: 44, right: 14 } as const;
/** Least distance of two marks [px]. */
export const SPACE = 34;

/** Distances between marks of the time axis [s]: whole minutes where it is long. */
const TIME_STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300];

/** A mark of an axis, and what is written under it. */
export interface Tick {
  readonly at: number;
  readonly text: string;
}

/** What an axis that is `width` long [px] marks of a range. */
export type Marked = (range: Range, width: number) => Tick[];

/** Marks of the live plots, in seconds before the newest. */
export const secondsTicks: Marked = (range, width) => {
  const least = ((range.to - range.from) / width) * SPACE;
  const places = multiples(range, TIME_STEPS.find((step) => step >= least) ?? least);
  const labels = secondsLabels(places);
  return places.map((at, i) => ({ at, text: labels[i] }));
};

/** Marks of any x that counts in `unit`, which the last one carries. */
export function plainTicks(unit: string): Marked {
  return (range, width) => {
    const places = multiples(range, niceStep(((range.to - range.from) / width) * SPACE));
    return numberLabels(places).map((text, i) => ({
      at: places[i],
      text: i === places.length - 1 ? `${text} ${unit}` : text,
    }));
  };
}

/** All multiples of `step` in a range, with its ends. */
function multiples({ from, to }: Range, step: number): number[] {
  if (!(step > 0 && step < Infinity)) return [];
  const [first, last] = [Math.ceil(from / step - 1e-6), Math.floor(to / step + 1e-6)];
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => (first + i) * step);
}

const NICE = [1, 2, 5, 10];

/** The smallest 1, 2 or 5 times a power of ten that is at least `value`. */
export function niceStep(value: number): number {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * (NICE.find((n) => n * decade >= value * (1 - 1e-9)) ?? 10);
}

/** Decimals that tell apart a hundredth of the axis, so that a readout neither flickers nor hides a change. */
export function digitsFor([low, high]: readonly [number, number]): number {
  return Math.max(0, Math.min(9, Math.ceil(-Math.log10((high - low) / 100) - 1e-9)));
}

/** Seconds as "-2.5 s", or as "-3:20" where the window is long. */
export function timeLabel(t: number, digits: number): string {
  if (Math.abs(t) < 120) return `${plain(t, digits)} s`;
  const whole = Math.round(Math.abs(t));
  return `${t < 0 ? "-" : ""}${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** The last label carries the unit. */
function secondsLabels(splits: readonly number[]): string[] {
  const long = splits.some((t) => Math.abs(t) >= 120);
  return splits.map((t, i) => {
    if (long) return timeLabel(t, 0);
    return i === splits.length - 1 ? `${round(t)} s` : String(round(t));
  });
}

export function numberLabels(splits: readonly number[]): string[] {
  return splits.map((y) =>
    y !== 0 && (Math.abs(y) < 1e-3 || Math.abs(y) >= 1e6) ? y.toExponential(0) : String(round(y)),
  );
}

function round(value: number): number {
  return Number(value.toFixed(4));
}
