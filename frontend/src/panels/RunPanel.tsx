import "../draw.css";
import { SegmentedControl } from "@mantine/core";
import { DrawPanel } from "./DrawPanel";
import { ReferencePanel } from "./ReferencePanel";
import { RunBar } from "./RunBar";
import { RunNews } from "./RunNews";
import { useDashboard } from "./context";
import { useRuns } from "./useDrawing";

/** What to follow, above; below, always in sight: what came of it or would, and the button that runs it. */
export function RunPanel() {
  const { runs } = useDashboard();
  const source = useRuns((choice) => choice.source);
  return (
    <div className="run">
      <div className="panel run-subject">
        <SegmentedControl
          size="xs"
          aria-label="What to follow"
          value={source}
          onChange={(value) => {
            runs.choose(value === "drawing" ? "drawing" : "library");
          }}
          data={[
            { value: "library", label: "Library" },
            { value: "drawing", label: "Drawing" },
          ]}
        />
        {source === "drawing" ? <DrawPanel /> : <ReferencePanel />}
      </div>
      <RunNews />
      <RunBar />
    </div>
  );
}
