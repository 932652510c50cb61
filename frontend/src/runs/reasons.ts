import type { ReferenceInfo } from "../api/types";
import { isPlanned, sketchOf, type DrawingState } from "../drawing/drawing";
import type { Source } from "./runs";

/** Why what is chosen can be neither previewed nor run, as one sentence; null when it can. */
export function whyNotRun(
  source: Source,
  drawing: DrawingState,
  chosen: ReferenceInfo | null,
): string | null {
  if (source === "drawing") return whyNotDrawing(drawing);
  if (!chosen) return "Choose a reference first";
  return chosen.reachable ? null : chosen.reason;
}

function whyNotDrawing(drawing: DrawingState): string | null {
  if (sketchOf(drawing).pieces.length === 0) return "Nothing is drawn";
  if (drawing.problem !== "") return drawing.problem;
  if (!drawing.plan || !isPlanned(drawing)) return "Being planned";
  return drawing.plan.reachable ? null : drawing.plan.reason;
}
