import type { PlotChannel, Quick, QuickSignal } from "../../api/types";
import { chartOf, type Look } from "../../plots/chart/charts";
import { displayOf } from "../../plots/signals";
import { LINES } from "../../ui/colours";
import { runClock, runRows, type Stretch } from "./course";

/** Values of one plot as uPlot takes them, in display units: x, then a column per line; null is a gap. */
export type Columns = [number[], ...(number | null)[][]];

export interface PlotLine {
  readonly label: string;
  readonly colour: string;
  readonly look: Look;
  /** Takes the place of the look's own dash. */
  readonly dash?: readonly number[];
}

export interface QuickChart {
  readonly title: string;
  readonly unit: string;
  readonly lines: readonly PlotLine[];
  readonly columns: Columns;
  /** What lies where on x, where that is a recording's own time. */
  readonly stretches?: readonly Stretch[];
}

/** Title, signals, and what of their names the title says already. */
const PLOTS: readonly (readonly [string, readonly string[], RegExp])[] = [
  ["Tip x", ["p_ref.0", "p_meas.0", "p_hat.0"], / x$/],
  ["Tip y", ["p_ref.1", "p_meas.1", "p_hat.1"], / y$/],
  ["Error and residual", ["error.norm", "residual"], /^observer /],
  ["Torque", ["u.0", "u.1"], /^torque /],
  [
    "Chamber pressures",
    [0, 1, 2, 3].flatMap((i) => [`pressure_meas.${i}`, `pressure_cmd.${i}`]),
    /^pressure (command )?/,
  ],
  ["Timing", ["lateness_ns", "step_ns"], / time$/],
];

/** All signals that are drawn. */
export const DRAWN: readonly string[] = PLOTS.flatMap(([, keys]) => keys);

/** The plots of one recording in the colours of the live plots; what it does not hold is left out. */
export function quickCharts(quick: Quick): QuickChart[] {
  const channels = quick.signals.map(channelOf);
  return PLOTS.flatMap(([title, wanted, said]) => {
    const chart = chartOf({ title, channels: wanted.filter((key) => holds(quick, key)) }, channels);
    if (chart.lines.length === 0) return [];
    const lines = chart.lines.map(({ name, colour, look }) => ({
      label: name.replace(said, ""),
      colour,
      look,
    }));
    const series = chart.lines.map(({ channel }) => scaled(quick.signals[channel].values, chart.scale));
    const { stretches } = quick;
    return [{ title, unit: chart.unit, lines, columns: [quick.t, ...series], stretches }];
  });
}

/** A recording beside others. */
export interface Compared {
  readonly quick: Quick;
}

/** Told apart by dash, not by colour alone; no role's colour, as each run has all roles. */
export const RUN_STYLES: readonly (PlotLine & { readonly dash: readonly number[] })[] = [
  { label: "1", colour: LINES[0], look: "solid", dash: [] },
  { label: "2", colour: LINES[1], look: "solid", dash: [9, 4] },
  { label: "3", colour: LINES[5], look: "solid", dash: [2, 3] },
  { label: "4", colour: LINES[6], look: "solid", dash: [10, 3, 2, 3] },
];

const COMPARED: readonly (readonly [string, string])[] = [
  ["Tip x, measured", "p_meas.0"],
  ["Tip y, measured", "p_meas.1"],
  ["Error", "error.norm"],
  ["Torque u1", "u.0"],
  ["Torque u2", "u.1"],
  ["Observer residual", "residual"],
];

export type Common = "time" | "phase";

/** One plot per quantity with a line per recording, on the runs' own clocks [s] or phase [0, 1) of the reference's period. */
export function comparedCharts(runs: readonly Compared[], common: Common): QuickChart[] {
  return COMPARED.flatMap(([title, key]) => {
    const present = runs.flatMap(({ quick }, place) => {
      const signal = quick.signals.find((one) => one.key === key);
      return signal && holds(quick, key) ? [{ quick, signal, place }] : [];
    });
    if (present.length === 0) return [];
    const { unit, scale } = displayOf(present[0].signal.unit);
    const tables = present.map(({ quick, signal }): Columns => {
      const values = scaled(signal.values, scale);
      return common === "phase" ? folded(quick, values) : onRunClock(quick, values);
    });
    const lines = present.map(({ place }) => RUN_STYLES[place]);
    return [{ title, unit, lines, columns: joined(tables) }];
  });
}

const PHASES = 100;

/** What the run was from its start on, whatever came before it and between. */
export function onRunClock(
  { t, stretches }: Pick<Quick, "t" | "stretches">,
  values: readonly (number | null)[],
): Columns {
  const run = runRows(t, stretches);
  return [run.t, run.places.map((place) => values[place])];
}

/** The median over all cycles at each phase, of the middles of the bins: one cycle, whatever came before the first and after the last. */
export function folded(
  {
    t,
    stretches,
    period,
    cycle_start,
    cycle_end,
  }: Pick<Quick, "t" | "stretches" | "period" | "cycle_start" | "cycle_end">,
  values: readonly (number | null)[],
): Columns {
  const bins: number[][] = Array.from({ length: PHASES }, () => []);
  const clock = runClock(stretches);
  const begin = clock(cycle_start);
  if (period !== null && begin !== null)
    for (let i = 0; i + 1 < values.length; i += 2) {
      const [low, high] = [values[i], values[i + 1]];
      const middle = (t[i] + t[i + 1]) / 2;
      const at = clock(middle);
      if (low === null || high === null || at === null || at < begin || middle > cycle_end) continue;
      const turns = (at - begin) / period;
      bins[Math.floor((turns - Math.floor(turns)) * PHASES) % PHASES].push((low + high) / 2);
    }
  return [bins.map((_, i) => (i + 0.5) / PHASES), bins.map(median)];
}

/** Tables with an x of their own on one x; between its own points a line goes straight on (undefined, not null). */
export function joined(tables: readonly Columns[]): Columns {
  const x = [...new Set(tables.flatMap(([times]) => times))].sort((a, b) => a - b);
  const places = new Map(x.map((value, i) => [value, i]));
  const series = tables.map(([times, values]) => {
    const column = new Array<number | null>(x.length);
    times.forEach((time, i) => {
      column[places.get(time) ?? 0] = values[i];
    });
    return column;
  });
  return [x, ...series];
}

/** Index of the value of the rising `x` that is nearest to `at`; -1 without any. */
export function nearest(x: readonly number[], at: number): number {
  let [low, high] = [0, x.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (x[middle] <= at) low = middle;
    else high = middle;
  }
  return high < 0 || Math.abs(x[low] - at) <= Math.abs(x[high] - at) ? Math.min(low, high) : high;
}

function channelOf({ key, field, index, label, unit }: QuickSignal): PlotChannel {
  return { key, field, index, unit, group: label, name: "" };
}

function holds(quick: Quick, key: string): boolean {
  return quick.signals.some((signal) => signal.key === key && signal.values.some((value) => value !== null));
}

function scaled(values: readonly (number | null)[], scale: number): (number | null)[] {
  return values.map((value) => (value === null ? null : value * scale));
}

function median(values: readonly number[]): number | null {
  if (values.length === 0) return null;
  const sorted = values.toSorted((a, b) => a - b);
  return (sorted[(sorted.length - 1) >> 1] + sorted[sorted.length >> 1]) / 2;
}
