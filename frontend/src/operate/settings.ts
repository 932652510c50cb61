import { SETTING_BOUNDS } from "../api/bounds";
import type { RigInfo, Settings } from "../api/types";
import { rounded } from "../ui/format";

export type PairName = "K_P" | "K_I" | "K_FF" | "K_o" | "B_o" | "u_open";
export type ScalarName = "feedforward_period" | "speed_max" | "acceleration_max";

/** How a live setting is shown: `scale` turns SI into the display unit. */
export interface Shown<Name> {
  readonly name: Name;
  readonly label: string;
  readonly meaning: string;
  readonly unit: string;
  readonly scale: number;
  readonly step: number;
}

export const PAIRS: readonly Shown<Exclude<PairName, "u_open">>[] = [
  { name: "K_P", label: "K_P", meaning: "Proportional", unit: "1", scale: 1, step: 0.05 },
  { name: "K_I", label: "K_I", meaning: "Integral", unit: "1/s", scale: 1, step: 0.1 },
  { name: "K_FF", label: "K_FF", meaning: "Velocity feedforward", unit: "s", scale: 1, step: 0.01 },
  { name: "K_o", label: "K_o", meaning: "Observer stiffness", unit: "N/m", scale: 1, step: 10 },
  { name: "B_o", label: "B_o", meaning: "Observer damping", unit: "N s/m", scale: 1, step: 0.1 },
];

export const SCALARS: readonly Shown<ScalarName>[] = [
  {
    name: "feedforward_period",
    label: "T_ff",
    meaning: "Feedforward period",
    unit: "ms",
    scale: 1e3,
    step: 1,
  },
  { name: "speed_max", label: "v_max", meaning: "Target speed, most", unit: "mm/s", scale: 1e3, step: 10 },
  {
    name: "acceleration_max",
    label: "a_max",
    meaning: "Target acceleration, most",
    unit: "mm/s²",
    scale: 1e3,
    step: 100,
  },
];

export const OPEN_LOOP: Shown<"u_open"> = {
  name: "u_open",
  label: "u",
  meaning: "Open-loop command",
  unit: "mN m",
  scale: 1e3,
  step: 0.5,
};

/** Lowest and highest value in the display unit; of the observer's gains what `rig` takes. */
export function limits(
  { name, scale }: Shown<PairName | ScalarName>,
  rig: RigInfo | null = null,
): { min: number; max: number } {
  const { minimum, maximum } = SETTING_BOUNDS[name];
  const [K_o, B_o] = rig?.observer_gains_max ?? [Infinity, Infinity];
  const taken = name === "K_o" ? K_o : name === "B_o" ? B_o : Infinity;
  return { min: rounded(minimum * scale), max: rounded(Math.min(maximum, taken) * scale) };
}

/** Bounds and unit as they stand beside a field: "0 … 500 N/m". */
export function boundsText(shown: Shown<PairName | ScalarName>, rig: RigInfo | null = null): string {
  const { min, max } = limits(shown, rig);
  return `${min} … ${max}${shown.unit === "1" ? "" : ` ${shown.unit}`}`;
}

/** Law, gains and limits among all settings: what the Gains panel shows, and a preset brings back. */
export function gainsOf(settings: Settings): Partial<Settings> {
  const { K_P, K_I, K_FF, K_o, B_o, law, feedforward_period, speed_max, acceleration_max } = settings;
  return { K_P, K_I, K_FF, K_o, B_o, law, feedforward_period, speed_max, acceleration_max };
}

/** The server's defaults of everything in the Gains panel; the choice of sensors and the open-loop command stay. */
export function defaultGains(): Partial<Settings> {
  const { K_P, K_I, K_FF, K_o, B_o, law, feedforward_period, speed_max, acceleration_max } = SETTING_BOUNDS;
  return {
    law: law.default,
    K_P: [...K_P.default],
    K_I: [...K_I.default],
    K_FF: [...K_FF.default],
    K_o: [...K_o.default],
    B_o: [...B_o.default],
    feedforward_period: feedforward_period.default,
    speed_max: speed_max.default,
    acceleration_max: acceleration_max.default,
  };
}
