import { api, dataOf } from "../../api/rest";
import type { components } from "../../api/schema";
import type { FirstModeState } from "../../api/types";
import { DASH, hertz, localDate, millimetres, percent, plain } from "../../ui/format";

type Schemas = components["schemas"];

export type FirstModeInForce = Schemas["FirstModeInForce"];
export type PlantNumber = Schemas["PlantNumber"];

/** What is known of the first mode, and its measurement. */
export const firstMode = {
  read: () => dataOf(api.GET("/api/first-mode")),
  measure: () => dataOf(api.POST("/api/first-mode/measure", { body: { travel: TRAVEL, repeats: REPEATS } })),
  stop: () => dataOf(api.POST("/api/first-mode/stop")),
};

/** How far the tip moves from one side of its rest to the other [m], and how often there and back. */
export const TRAVEL = 0.1;
export const REPEATS = 3;

/** "0.33 (0.30 to 0.36), measured Nov 26, 2026", "0.35, assumed (fit to the paper)", or "0.19, from ...". */
export function numberText(number: PlantNumber, digits: number): string {
  const { value, source, low, high, measured, note } = number;
  const why = note === "" ? "" : ` (${note})`;
  if (source === "assumed") return `${plain(value, digits)}, assumed${why}`;
  if (source === "file") return `${plain(value, digits)}, from the actuator's file${why}`;
  if (source === "given") return `${plain(value, digits)}, given${why}`;
  const when = typeof measured === "string" ? ` ${localDate(measured)}` : "";
  return `${plain(value, digits)} (${plain(low, digits)} to ${plain(high, digits)}), ${source}${when}`;
}

/** What stability rests on: names with their values. */
export function modeFacts({ zeta, kappa, mode, observer_kappa }: FirstModeInForce): [string, string][] {
  const facts: [string, string][] = [
    ["Damping ratio", numberText(zeta, 2)],
    ["Stiffness factor κ", numberText(kappa, 1)],
    ["Observer's κ", observer_kappa === 1 ? "1, the actuator's table" : plain(observer_kappa, 1)],
  ];
  if (mode) {
    const { frequency, friction, misfit } = mode;
    const rest = `dry friction ±${millimetres(friction)}, ${percent(misfit, 1)} not explained`;
    facts.push(["First mode", `${hertz(frequency.value)}, ${rest}`]);
  }
  return facts;
}

/** A measurement this much nearer or farther tells nothing new: half or twice the true one is as good. */
const RATIO_AGREES_MAX = 1.3;

/** The kappa that the observer could have instead: the measured one, or the table's again; null where it has that. */
export function kappaToOffer({ mode, observer_kappa: now }: FirstModeInForce): number | null {
  const measured = mode === null ? 1 : Math.max(1, mode.kappa.value);
  const apart = Math.max(now / measured, measured / now);
  if (apart > RATIO_AGREES_MAX) return measured;
  return now === 1 ? null : 1;
}

/** How the measurement goes, or how the last one ended; "" where there is nothing to say. */
export function progressText(state: FirstModeState | null): string {
  if (state === null || state.state === "done") return "";
  if (state.state === "running") return `Measuring: ${state.doing}`;
  return `Not measured: ${state.reason === "" ? DASH : state.reason}`;
}
