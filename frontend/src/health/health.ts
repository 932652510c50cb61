import { ALARM_BOUNDS } from "../api/bounds";
import type { AlarmLimits } from "../api/types";
import { DASH, microseconds, millimetres, milliseconds, percent, seconds, wholeNumber } from "../ui/format";

export type Grade = "good" | "warning" | "bad" | "unknown";

/** Never colour alone: every grade has a mark and a word. */
export const GRADE_MARK: Record<Grade, string> = { good: "✓", warning: "▲", bad: "✖", unknown: "–" };
export const GRADE_WORD: Record<Grade, string> = {
  good: "good",
  warning: "watch",
  bad: "bad",
  unknown: "no data",
};

export type Measure =
  | "onTime"
  | "lost"
  | "lateness"
  | "step"
  | "roundTrip"
  | "rigLink"
  | "commandAge"
  | "presenceAge"
  | "measurementAge"
  | "residual"
  | "pressureLag"
  | "ledger";

export type Alarm = keyof AlarmLimits;

/** Beyond `amber` a number is to be watched, beyond `red` it is bad; SI units. */
export interface Limits {
  readonly amber: number;
  readonly red: number;
}

/** A number of the health display; its limits are fixed, or an alarm's, which each user may set. */
export interface Gauge {
  readonly name: string;
  readonly meaning: string;
  readonly limits: Limits | Alarm;
  readonly show: (value: number) => string;
}

const ms = (value: number) => milliseconds(value);
const age = (value: number) => (value < 10 ? milliseconds(value, 0) : seconds(value));
const us = (value: number) => microseconds(value * 1e9);
const millijoules = (value: number) => (Number.isFinite(value) ? `${(value * 1e3).toFixed(3)} mJ` : DASH);

export const GAUGES: Record<Measure, Gauge> = {
  onTime: {
    name: "on time",
    meaning: "Share of 1 kHz slots in which the loop ticked, last minute",
    limits: "on_time",
    show: percent,
  },
  lost: {
    name: "lost ticks",
    meaning: "Slots of the last minute in which the loop did not tick",
    limits: "lost_ticks",
    show: wholeNumber,
  },
  lateness: {
    name: "wake-up lateness",
    meaning: "Wake-up after the deadline; 99 of 100 ticks of the last 10 s were earlier",
    limits: "lateness_p99",
    show: us,
  },
  step: {
    name: "step time",
    meaning: "Duration of one controller tick, plant excluded; of 1000 µs",
    limits: { amber: 0.5e-3, red: 0.9e-3 },
    show: us,
  },
  roundTrip: {
    name: "round trip",
    meaning: "Page to server and back",
    limits: "round_trip",
    show: ms,
  },
  rigLink: {
    name: "rig link",
    meaning: "Server to the rig's loop and back, median of the last commands",
    limits: { amber: 0.02, red: 0.1 },
    show: ms,
  },
  commandAge: {
    name: "command age",
    meaning: "Since the rig's last command, new or repeated; repeated every 100 ms",
    limits: "command_age",
    show: age,
  },
  presenceAge: {
    name: "operator heartbeat",
    meaning: "Since the operator's page gave its last sign of life, 20 a second",
    limits: { amber: 0.25, red: 0.5 },
    show: age,
  },
  measurementAge: {
    name: "measurement age",
    meaning: "Age of the newest marker measurement; the largest of the last moments",
    limits: { amber: 0.025, red: 0.05 },
    show: age,
  },
  residual: {
    name: "residual",
    meaning: "Measured minus observer, RMS over the sensed rods",
    limits: "residual",
    show: (value) => millimetres(value, 2),
  },
  pressureLag: {
    name: "time constant",
    meaning:
      "Filling: τ of dp/dt = (command(t − d) − p) / τ, fitted with the dead time d to command and measured pressure " +
      "of all chambers over the last 30 s; fit is the share of their motion that this explains. The model has 50 ms. " +
      "No value while the pressures rest",
    limits: { amber: 0.1, red: 0.2 },
    show: (value) => milliseconds(value, 0),
  },
  ledger: {
    name: "energy balance",
    meaning:
      "What the observer's integrator added in the last 10 s: stored energy minus the work of the four powers; " +
      "less than 0 is what its steps lost, as they may. " +
      "No value where ticks were lost or the observer was set anew meanwhile",
    limits: { amber: 100e-6, red: 1e-3 },
    show: millijoules,
  },
};

/** The limits of a gauge: the user's own, before they are known the defaults. */
export function limitsOf(measure: Measure, alarms: AlarmLimits | null): Limits {
  const { limits } = GAUGES[measure];
  return typeof limits === "string" ? (alarms?.[limits] ?? ALARM_BOUNDS[limits].default) : limits;
}

/** How good `value` is; nan is unknown. Most gauges are bad when large, shares are bad when small. */
export function gradeOf(measure: Measure, value: number, alarms: AlarmLimits | null = null): Grade {
  const { amber, red } = limitsOf(measure, alarms);
  if (!Number.isFinite(value)) return "unknown";
  const size = measure === "ledger" ? value : Math.abs(value); // an integrator may lose energy, never add any
  const beyond = (limit: number) => (isShare(measure) ? value < limit : size > limit);
  if (beyond(red)) return "bad";
  return beyond(amber) ? "warning" : "good";
}

/** What the gauge means and from where on it is to be watched or bad. */
export function meaningOf(measure: Measure, alarms: AlarmLimits | null = null): string {
  const { meaning, show } = GAUGES[measure];
  const { amber, red } = limitsOf(measure, alarms);
  const side = isShare(measure) ? "below" : "above";
  return `${meaning}. Watch ${side} ${show(amber)}, bad ${side} ${show(red)}.`;
}

/** Place of the worst grade, the first of several; what is not known is no worse than good. */
export function worstOf(grades: readonly Grade[]): number {
  const worst = (["bad", "warning", "good"] as const).find((grade) => grades.includes(grade));
  return worst ? grades.indexOf(worst) : 0;
}

function isShare(measure: Measure): boolean {
  return measure === "onTime";
}

/** The larger of the newest value and a slowly forgotten maximum: an age that saws between 0 and 10 ms reads as 10. */
export class Peak {
  private held = NaN;

  take(value: number): number {
    const before = Number.isFinite(this.held) ? this.held : value;
    this.held = Number.isFinite(value) ? Math.max(value, 0.7 * before) : NaN;
    return this.held;
  }
}
