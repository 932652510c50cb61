import { niceStep } from "../../plots/chart/axes";

/** Distances of grid lines and length of the scale bar [m] that read well at `scale` pixels per metre. */
export interface Grid {
  readonly minor: number;
  readonly major: number;
  readonly bar: number;
}

const MINOR_PX = 9;
const MAJOR_PX = 60;
const BAR_PX = 70;

export function gridFor(scale: number): Grid {
  const major = niceStep(MAJOR_PX / scale);
  return { minor: Math.max(niceStep(MINOR_PX / scale), major / 10), major, bar: niceStep(BAR_PX / scale) };
}

/** Multiples of `step` in [from, to]. */
export function ticks(from: number, to: number, step: number): number[] {
  const first = Math.ceil(from / step);
  return Array.from({ length: Math.max(0, Math.floor(to / step) - first + 1) }, (_, i) => (first + i) * step);
}

/** A length as a label: 50 mm, 0.5 mm. */
export function lengthLabel(metres: number): string {
  return `${Number((metres * 1e3).toPrecision(3))} mm`;
}
