import { DrawPanel } from "../drawing/DrawPanel";
import { ReferencePanel } from "../drawing/library/ReferencePanel";
import { RunBar } from "./RunBar";
import { RunNews } from "./RunNews";
import { useRuns } from "../drawing/useDrawing";

/** What to follow, above; below, always in sight: what came of it or would, and the button that runs it. */
export function RunPanel() {
  const source = useRuns((choice) => choice.source);
  return (
    <div className="run">
      <div className="panel run-subject">{source === "drawing" ? <DrawPanel /> : <ReferencePanel />}</div>
      <RunNews />
      <RunBar />
    </div>
  );
}
