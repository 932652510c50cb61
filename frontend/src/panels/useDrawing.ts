import type { DrawingState } from "../state/drawing";
import type { RunChoice } from "../state/run";
import { useStore } from "../state/store";
import { useDashboard } from "./context";

/** Follow a part of the drawing. */
export function useDrawing<S>(select: (drawing: DrawingState) => S): S {
  return useStore(useDashboard().drawing.store, select);
}

/** Follow what would be run. */
export function useRuns<S>(select: (choice: RunChoice) => S): S {
  return useStore(useDashboard().runs.store, select);
}
