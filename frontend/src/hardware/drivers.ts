import { api, dataOf } from "../api/rest";
import type { components } from "../api/schema";
import { DASH, milliseconds, percent, plain, wholeNumber } from "../ui/format";

export type DriverStatus = components["schemas"]["DriverStatus"];
type DriverState = DriverStatus["state"];

/** How each of the rig's devices fares, now. */
export const readDrivers = async () => (await dataOf(api.GET("/api/drivers"))).drivers;

export const ROLE_WORD: Record<DriverStatus["role"], string> = {
  motion_capture: "Motion capture",
  valves: "Valves",
};

/** What a state is worth: its colour and mark. */
export const GRADE: Record<DriverState, "good" | "warning" | "bad"> = {
  running: "good",
  opening: "warning",
  silent: "bad",
  lost: "bad",
};

export const MARK: Record<DriverState, string> = { running: "●", opening: "◌", silent: "▲", lost: "■" };

/** What a state means where the driver itself says nothing about it. */
const MEANING: Record<DriverState, string> = {
  running: "",
  opening: "The device is being opened.",
  silent: "The device is open, and nothing usable comes from it.",
  lost: "The device does not answer. It is tried again until it does.",
};

/** From when on the newest frame is called old [s]. */
const OLD = 0.2;

/** What is wrong, as one sentence; "" where nothing is. */
export function trouble({ state, detail, age }: DriverStatus): string {
  if (detail !== "") return sentence(detail);
  if (state === "running" && age > OLD) return `The newest frame is ${milliseconds(age, 0)} old.`;
  return MEANING[state];
}

function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".");
}

/** Frames that did not come, of all that were sent; nan before the first. */
export function lossOf({ frames, lost }: Pick<DriverStatus, "frames" | "lost">): number {
  return frames + lost === 0 ? NaN : lost / (frames + lost);
}

const CLOCK: Record<DriverStatus["clock"], string> = {
  "two-way": "two-way",
  "one-way": "one-way",
  arrival: "time of arrival",
};

/** What a sentence about it is worth: one that a running device has to say of itself is a warning. */
export function troubleGrade({ state, detail }: Pick<DriverStatus, "state" | "detail">) {
  return state === "running" && detail !== "" ? "warning" : GRADE[state];
}

/** How it fares in numbers: names with their values. */
export function driverFacts(driver: DriverStatus): [string, string][] {
  const { rate, age, latency, clock, clock_offset, lost, frames, late, rejected, reconnects } = driver;
  return [
    ["Rate", `${plain(rate, 0)} /s`],
    ["Age", age < 0 ? DASH : milliseconds(age, age < 0.1 ? 1 : 0)],
    ["Latency", latency < 0 ? "not known" : milliseconds(latency)],
    ["Clock", CLOCK[clock]],
    ["Offset", clock === "arrival" ? DASH : `${plain(clock_offset, 4)} s`],
    ["Lost", `${wholeNumber(lost)} of ${wholeNumber(frames + lost)} (${percent(lossOf(driver))})`],
    ["Late answers", wholeNumber(late)],
    ["Rejected", wholeNumber(rejected)],
    ["Reconnects", wholeNumber(reconnects)],
  ];
}

/** A raw number as it came, in the device's own unit, with five figures or so. */
export function raw(value: number | null): string {
  if (value === null || !Number.isFinite(value)) return DASH;
  const size = Math.abs(value);
  return plain(value, size < 10 ? 4 : size < 1000 ? 2 : 0);
}

/** Names of raw values in the order of their numbers: "#2" before "#10". */
export function namesOf(values: DriverStatus["values"]): string[] {
  return Object.keys(values).toSorted((a, b) => a.localeCompare(b, undefined, { numeric: true }));
}
