import { Button } from "@mantine/core";
import { useService } from "../../ui/services";
import { Drawing, useDrawing, type Tool } from "../drawing";
import { SelectBar } from "./SelectBar";

const HINT: Record<Tool, string> = {
  drag: "",
  select: "",
  freehand: "Press and draw. Two fingers or the middle button move the picture.",
  polyline: "Click the corners; the last one again, or Enter, ends. Esc drops the line and holds the rig.",
};

/** How the chosen tool is used, and a way to end a line for those without a keyboard. */
export function DrawHint() {
  const drawing = useService(Drawing);
  const tool = useDrawing((state) => state.tool);
  const open = useDrawing((state) => state.tool === "polyline" && state.stroke.length > 1);
  if (tool === "drag") return null;
  if (tool === "select") return <SelectBar />;
  return (
    <div className="draw-hint" role="status">
      {HINT[tool]}
      {open ? (
        <Button
          size="compact-xs"
          variant="default"
          data-testid="end-line"
          onClick={() => {
            drawing.finishStroke();
          }}
        >
          End the line
        </Button>
      ) : null}
    </div>
  );
}
