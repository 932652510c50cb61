import type { Learned, Preview, RunResult, RunState } from "../api/types";
import { degrees, millimetres, percent, plain, velocityGain } from "../ui/format";

type Facts = readonly (readonly [string, string])[];

export const STATE_WORD: Record<RunState["state"], string> = {
  approach: "Approach",
  running: "Running",
  paused: "Paused",
  done: "Done",
  stopped: "Stopped",
  "broken off": "Broken off",
};

/** A distance with hundredths of a millimetre where they say something. */
export function errorText(error: number | null): string {
  return millimetres(error, error !== null && error < 0.01 ? 2 : 1);
}

/** The prediction in two short lines. */
export function previewText({ rmse, max_error, saturated_share, broken_off, K_FF }: Preview): string[] {
  if (broken_off !== "") return ["Would be broken off:", broken_off];
  const fed = K_FF.some((gain) => gain > 0) ? `, K_FF ${velocityGain(K_FF)}` : "";
  return [
    `RMSE ${errorText(rmse)}, max ${errorText(max_error)}`,
    `predicted; saturated ${percent(saturated_share, 1)}${fed}`,
  ];
}

/** What came of a run, beside what was predicted; without a lag where nothing is periodic. */
export function resultFacts(result: RunResult, foreseen: number | null): Facts {
  const { rmse, max_error, lag_deg_x, lag_deg_y, saturated_share, on_time_share } = result;
  const facts: (readonly [string, string])[] = [
    ["RMSE", errorText(rmse)],
    ["Max error", errorText(max_error)],
  ];
  if (foreseen !== null) facts.splice(1, 0, ["Foreseen", errorText(foreseen)]);
  if (lag_deg_x !== null) facts.push(["Lag x", degrees(lag_deg_x)]);
  if (lag_deg_y !== null) facts.push(["Lag y", degrees(lag_deg_y)]);
  if (result.controller !== "") facts.push(["Controller", result.controller]);
  if (result.K_FF.some((gain) => gain > 0)) facts.push(["K_FF", velocityGain(result.K_FF)]);
  facts.push(["Saturated", percent(saturated_share, 1)], ["On time", percent(on_time_share)]);
  return facts;
}

/** What a run had of what was learned: "Repeat 3: 1.2 mm" while it is, then the best of them. */
export function learnedText({ learning, errors }: Learned): string {
  const known = errors.filter((error) => error !== null);
  const best = errorText(known.length > 0 ? Math.min(...known) : null);
  if (learning) return `Repeat ${errors.length}: best ${best}`;
  return `Learned in ${errors.length} ${errors.length === 1 ? "repeat" : "repeats"}: best ${best}`;
}

/** The recorded run of the same thing before `result`; `results` have the newest first. */
export function earlierOf(result: RunResult, results: readonly RunResult[]): RunResult | null {
  const same = ({ id, name, recording }: RunResult) =>
    id < result.id && name === result.name && recording !== null && recording !== result.recording;
  return results.find(same) ?? null;
}

/** Laps done of those wanted: 2, 1 of 3, 0.4 of 1. */
export function lapText({ lap, laps }: RunState): string {
  return laps === null ? `lap ${lap}` : `lap ${lap} of ${laps}`;
}

export function lapsDone({ laps }: RunResult): string {
  return `${plain(laps, Number.isInteger(laps) ? 0 : 1)} ${laps === 1 ? "lap" : "laps"}`;
}
