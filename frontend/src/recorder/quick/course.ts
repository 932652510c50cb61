import type { Quick } from "../../api/types";

export type Stretch = Quick["stretches"][number];

/** Page words for what lies around a run. */
export const STRETCH_WORD: Record<Stretch["kind"], string> = {
  before: "before",
  approach: "approach",
  run: "run",
  pause: "pause",
  after: "after",
};

/** How long the run had been followed at a time since the first row [s]; null where it was not. */
export type RunClock = (t: number) => number | null;

/** The run's own clock: it stands still in pauses and approaches, so runs of one path go side by side. */
export function runClock(stretches: readonly Stretch[]): RunClock {
  let passed = 0;
  const legs = stretches.flatMap(({ kind, start, end }) => {
    if (kind !== "run") return [];
    const leg = { start, end, passed };
    passed += end - start;
    return [leg];
  });
  return (t) => {
    const leg = legs.findLast(({ start }) => t >= start);
    return leg && t <= leg.end ? t - leg.start + leg.passed : null;
  };
}

/** Rows of a recording that are of its run: their places, and their times on its clock. */
export function runRows(
  times: readonly number[],
  stretches: readonly Stretch[],
): { readonly places: number[]; readonly t: number[] } {
  const clock = runClock(stretches);
  const [places, t]: [number[], number[]] = [[], []];
  times.forEach((time, place) => {
    const at = clock(time);
    if (at === null) return;
    places.push(place);
    t.push(at);
  });
  return { places, t };
}

/** When what was recorded begins [s]: with its run, or after the part from before its start. */
export function beginOf(stretches: readonly Stretch[]): number {
  const run = stretches.find(({ kind }) => kind === "run");
  return (run ?? stretches.find(({ kind }) => kind !== "before"))?.start ?? 0;
}

/** So much of what comes before a run is seen beside it. */
const MARGIN = 0.04;

/** The part of the time in which a run is seen, with a strip of what is around it; null where it is all there is. */
export function runWindow(
  stretches: readonly Stretch[],
): { readonly from: number; readonly to: number } | null {
  const legs = stretches.filter(({ kind }) => kind === "run");
  const [first, last] = [legs.at(0), legs.at(-1)];
  if (!first || !last || legs.length === stretches.length) return null;
  const margin = MARGIN * (last.end - first.start);
  return {
    from: Math.max(0, first.start - margin),
    to: Math.min(stretches.at(-1)?.end ?? last.end, last.end + margin),
  };
}
