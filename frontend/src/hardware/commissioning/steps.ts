import type { components } from "../../api/schema";
import { DASH, plain } from "../../ui/format";
import { typedNumber, type Typed } from "../../ui/numbers/typed";

type Schemas = components["schemas"];

export type CommissioningState = Schemas["CommissioningState"];
export type StepView = Schemas["StepView"];
export type StepName = StepView["name"];
export type StartBody = Schemas["StartBody"];
export type Found = Schemas["Number"];
export type Change = Schemas["Change"];
export type Chamber = NonNullable<Schemas["JogBody"]["chamber"]>;
export type Jogged = Schemas["Jogged"];
export type Captured = Schemas["Captured"];
export type Place = Captured["place"];

export const CHAMBERS = ["u1+", "u1-", "u2+", "u2-"] as const satisfies readonly Chamber[];

/** How a step stands, in a word, and what that is worth. */
export interface Standing {
  readonly word: string;
  readonly mark: string;
  readonly grade: "good" | "warning" | "bad" | "unknown";
}

export function standingOf({ state, accepted, needs }: StepView): Standing {
  if (state === "running") return { word: "under way", mark: "▶", grade: "warning" };
  if (state === "failed") return { word: "failed", mark: "■", grade: "bad" };
  if (accepted) return { word: "accepted", mark: "✓", grade: "good" };
  if (state === "done") return { word: "to be accepted", mark: "●", grade: "warning" };
  return needs.length === 0
    ? { word: "next", mark: "○", grade: "warning" }
    : { word: "to do", mark: "○", grade: "unknown" };
}

/** The step that wants attention: the one under way, else the first that is not accepted; null when all are. */
export function nextStep({ running, steps }: Pick<CommissioningState, "running" | "steps">): StepName | null {
  return running?.step ?? steps.find(({ accepted }) => !accepted)?.name ?? null;
}

/** What a rig lacks, as one line; "" where it is commissioned or cannot be. */
export function lackingText({ available, complete, missing }: CommissioningState): string {
  if (!available || complete) return "";
  return `Not commissioned: ${missing.join(", ")}`;
}

/** What a step asks for before it begins. */
export interface Input {
  readonly name: keyof StartBody;
  readonly label: string;
  readonly unit: string;
  /** From SI to the display unit. */
  readonly scale: number;
  readonly min: number;
  readonly max: number;
  /** Of the pressure that full torque takes, where that is less than `max` (server/hardware/commissioning). */
  readonly share?: number;
  readonly step: number;
  /** What stands there at first, SI; null: as much as the step usually takes. */
  readonly usual: number | null;
}

const PRESSURE = {
  name: "pressure",
  label: "Pressure",
  unit: "kPa",
  scale: 1e-3,
  min: 5,
  step: 1,
  usual: null,
} as const;
const LOW: Input = { ...PRESSURE, max: 40, share: 0.2 };
const SHARE: Input = {
  name: "share",
  label: "Of the torque limits",
  unit: "%",
  scale: 100,
  min: 20,
  max: 90,
  step: 5,
  usual: 0.7,
};
const counted = (label: string): Input => ({
  name: "repeats",
  label,
  unit: "",
  scale: 1,
  min: 1,
  max: 6,
  step: 1,
  usual: 3,
});

export const INPUTS: Record<StepName, readonly Input[]> = {
  drivers: [],
  jog: [LOW],
  frame: [LOW],
  signs: [LOW],
  pressure: [{ ...PRESSURE, max: 150, share: 0.5 }, counted("Repeats")],
  statics: [
    { name: "grid", label: "Torques of each pair", unit: "", scale: 1, min: 3, max: 9, step: 1, usual: 5 },
    SHARE,
  ],
  decay: [counted("Releases to each side"), SHARE],
  identify: [],
  closed_loop: [counted("Laps")],
};

/** The most that may be typed for an actuator whose chambers take `full` [Pa] at full torque, in the display unit. */
export function mostOf({ max, share, scale }: Input, full: number): number {
  return share === undefined ? max : Math.min(max, Math.floor(share * full * scale));
}

/** What a step does to the arm once it is started, said before it does; "" where nothing moves. */
export const MOVES: Record<StepName, string> = {
  drivers: "",
  jog: "A chamber fills only while its button is held, and at low pressure.",
  frame: "The arm moves once: u1+ fills for the bent pose.",
  signs: "The arm moves by itself: u1+ fills, then u2+, for 2 s each.",
  pressure: "The arm moves by itself: each chamber steps up and down.",
  statics: "The arm moves by itself through all poses, for some minutes.",
  decay: "The arm moves by itself: it is bent and let go.",
  identify: "",
  closed_loop: "The arm moves by itself, under feedback, around a small circle.",
};

/** What was typed, in display units; "" where a field was emptied. */
export type TypedInputs = Partial<Record<keyof StartBody, Typed>>;

/** The numbers that a step is begun with; what was not typed is as usual. */
export function bodyOf(step: StepName, typed: TypedInputs): StartBody {
  const body: StartBody = { pressure: null, repeats: 3, grid: 5, share: 0.7 };
  const asked = INPUTS[step].flatMap(({ name, scale }) => {
    const value = typedNumber(typed[name] ?? "");
    return value === null ? [] : [[name, value / scale] as const];
  });
  return { ...body, ...Object.fromEntries(asked) };
}

const UNITS: Partial<
  Record<string, { readonly scale: number; readonly unit: string; readonly digits: number }>
> = {
  Pa: { scale: 1e-3, unit: "kPa", digits: 1 },
  "Pa/s": { scale: 1e-3, unit: "kPa/s", digits: 0 },
  m: { scale: 1e3, unit: "mm", digits: 1 },
  s: { scale: 1e3, unit: "ms", digits: 1 },
};

/** A number that a step found, with its interval: "48.2 ms (47.9 to 48.6)". */
export function foundText({ value, unit, low, high }: Found): string {
  if (value === null) return DASH;
  const large = unit === "s" && Math.abs(value) >= 10;
  const {
    scale,
    unit: shown,
    digits,
  } = (large ? null : UNITS[unit]) ?? {
    scale: 1,
    unit: unit === "1" ? "" : unit,
    digits: figures(value),
  };
  const written = (one: number) => plain(one * scale, digits);
  const interval =
    typeof low === "number" && typeof high === "number" ? ` (${written(low)} to ${written(high)})` : "";
  return `${written(value)}${shown === "" ? "" : ` ${shown}`}${interval}`;
}

/** Decimals that leave three figures or so. */
function figures(value: number): number {
  if (Number.isInteger(value)) return 0;
  const size = Math.abs(value);
  return size === 0 ? 0 : Math.min(5, Math.max(0, 2 - Math.floor(Math.log10(size))));
}

/** A value of the rig file as it is written there. */
export function written(value: unknown): string {
  if (value === null || value === undefined) return "not given";
  if (typeof value === "number") return String(Number(value.toPrecision(6)));
  if (Array.isArray(value)) return `[${value.map(written).join(", ")}]`;
  return JSON.stringify(value);
}

/** Which sensor answered when a chamber was jogged, and whether that is right. */
export function answered({ commanded, rose, rises }: Jogged): {
  readonly text: string;
  readonly good: boolean;
} {
  if (rose === null) return { text: "no single sensor rose", good: false };
  const rise = `+${plain((rises[CHAMBERS.indexOf(rose)] ?? NaN) / 1e3, 0)} kPa`;
  return rose === commanded
    ? { text: `its own sensor rose, ${rise}`, good: true }
    : { text: `the sensor of ${rose} rose, ${rise}`, good: false };
}

/** The point that is captured where no one chose one: that of the tip's label, or the only one. */
export function usualPoint(
  names: readonly string[],
  labels: Readonly<Record<string, number>>,
): string | null {
  const tip = names.find((name) => labels[name] === TIP_ROD);
  return tip ?? (names.length === 1 ? (names[0] ?? null) : null);
}

const TIP_ROD = 10;
