import { plain } from "../../ui/format";

/** Distances between marks of the time axis [s]: whole minutes where it is long. */
export const TIME_STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300];

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

/** The first label would run into the y axis; the last one carries the unit. */
export function secondsLabels(splits: number[]): string[] {
  const long = splits.some((t) => Math.abs(t) >= 120);
  return splits.map((t, i) => {
    if (i === 0) return "";
    if (long) return timeLabel(t, 0);
    return i === splits.length - 1 ? `${round(t)} s` : String(round(t));
  });
}

export function numberLabels(splits: number[]): string[] {
  return splits.map((y) =>
    y !== 0 && (Math.abs(y) < 1e-3 || Math.abs(y) >= 1e6) ? y.toExponential(0) : String(round(y)),
  );
}

function round(value: number): number {
  return Number(value.toFixed(4));
}
