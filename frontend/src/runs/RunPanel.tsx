import { useDrawing } from "../drawing/drawing";
import { DrawPanel } from "../drawing/DrawPanel";
import { ReferencePanel } from "../drawing/library/ReferencePanel";
import { RunBar } from "./RunBar";
import { RunNews } from "./RunNews";

/** What to follow, above; below, always in sight: what came of it or would, and the button that runs it. */
export function RunPanel() {
  const source = useDrawing((state) => state.source);
  return (
    <div className="run">
      <div className="panel run-subject">{source === "drawing" ? <DrawPanel /> : <ReferencePanel />}</div>
      <RunNews />
      <RunBar />
    </div>
  );
}
