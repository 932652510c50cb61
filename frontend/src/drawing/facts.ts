import type { DrawingPlan } from "../api/types";
import {
  DASH,
  metresPerSquareSecond,
  millimetres,
  millimetresPerSecond,
  percent,
  seconds,
} from "../ui/format";
import type { Timing } from "./drawing";

type Facts = readonly (readonly [string, string])[];

/** What is said about a drawing; dashes while nothing is known, so that nothing moves. */
export function drawingFacts(plan: DrawingPlan | null): Facts {
  return [
    ["Length", millimetres(plan?.length, 0)],
    ["Duration", plan ? seconds(plan.duration, 1) : DASH],
    ["Travel", plan ? seconds(plan.travel_duration, 1) : DASH],
    ["Peak speed", plan ? millimetresPerSecond(plan.peak_speed) : DASH],
    ["Peak acceleration", metresPerSquareSecond(plan?.peak_acceleration)],
    ["Out of reach", percent(plan?.outside_share, 0)],
  ];
}

export const TIMINGS: readonly (readonly [Timing["kind"], string])[] = [
  ["speed", "Constant speed"],
  ["duration", "Duration"],
  ["fastest", "Fastest within limits"],
  ["given", "As in the file"],
];

/** The timing of another kind that takes about as long as the present plan. */
export function timingOf(kind: Timing["kind"], plan: DrawingPlan | null): Timing {
  switch (kind) {
    case "speed":
      return { kind, speed: plan ? clamped(round(plan.length / drawnTime(plan), 1e-3), 1e-3, 1) : 0.02 };
    case "duration":
      return { kind, duration: plan ? clamped(round(drawnTime(plan), 0.1), 0.1, 280) : 10 };
    case "fastest":
    case "given":
      return { kind };
  }
}

/** Without travel, which no timing is about [s]. */
function drawnTime({ duration, travel_duration }: DrawingPlan): number {
  return duration - travel_duration;
}

function round(value: number, step: number): number {
  return Number((Math.round(value / step) * step).toFixed(6));
}

function clamped(value: number, low: number, high: number): number {
  return Math.min(high, Math.max(low, value));
}
