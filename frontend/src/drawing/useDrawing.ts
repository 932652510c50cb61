import type { DrawingState } from "./drawing";
import type { RunChoice } from "../runs/runs";
import { useStore } from "../ui/store";
import { useDashboard } from "../ui/context";

/** Follow a part of the drawing. */
export function useDrawing<S>(select: (drawing: DrawingState) => S): S {
  return useStore(useDashboard().drawing.store, select);
}

/** Follow what would be run. */
export function useRuns<S>(select: (choice: RunChoice) => S): S {
  return useStore(useDashboard().runs.store, select);
}
