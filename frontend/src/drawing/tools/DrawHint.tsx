import { Button } from "@mantine/core";
import {
  IconLink,
  IconRotate2,
  IconRotateClockwise2,
  IconSelectAll,
  IconSquaresSelected,
  IconUnlink,
} from "@tabler/icons-react";
import { useService } from "../../ui/services";
import { Drawing, selectionOf, sketchOf, useDrawing, type Tool } from "../drawing";
import { Toolbar } from "../../ui/buttons/Toolbar";
import { ToolButton } from "../../ui/buttons/ToolButton";

const HINT: Record<Tool, string> = {
  drag: "",
  select: "",
  freehand: "Press and draw. Two fingers or the middle button move the picture.",
  polyline: "Click the corners; the last one again, or Enter, ends. Esc drops the line.",
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
          onClick={() => drawing.finishStroke()}
        >
          End the line
        </Button>
      ) : null}
    </div>
  );
}

const TURN = Math.PI / 12;

/** What can be done with several pieces at once; every key of it is a button, too. */
function SelectBar() {
  const drawing = useService(Drawing);
  const count = useDrawing((state) => sketchOf(state).selected.length);
  const empty = useDrawing((state) => sketchOf(state).pieces.length === 0);
  const grouped = useDrawing((state) => selectionOf(sketchOf(state)).some(({ group }) => group !== null));
  const several = useDrawing((state) => state.several);
  const actions = [
    ["select-all", "Select all (Ctrl A on the plan)", IconSelectAll, empty, () => { drawing.selectAll(); }],
    ["group", "Group (Ctrl G)", IconLink, count < 2, () => { drawing.group(true); }],
    ["ungroup", "Ungroup (Ctrl Shift G)", IconUnlink, !grouped, () => { drawing.group(false); }],
    ["turn-left", "Turn by 15° to the left", IconRotate2, count === 0, () => { drawing.turn(TURN); }],
    ["turn-right", "Turn by 15° to the right", IconRotateClockwise2, count === 0, () => { drawing.turn(-TURN); }],
  ] as const; // prettier-ignore
  return (
    <Toolbar className="draw-hint" label="Selection">
      <ToolButton
        label="Select several: what is pressed comes to what is selected (Shift)"
        testId="several"
        pressed={several}
        onClick={() => drawing.selectSeveral(!several)}
      >
        <IconSquaresSelected size={18} />
      </ToolButton>
      {actions.map(([testId, label, Picture, disabled, onClick]) => (
        <ToolButton key={testId} label={label} testId={testId} disabled={disabled} onClick={onClick}>
          <Picture size={18} />
        </ToolButton>
      ))}
      <span role="status" className="number" data-testid="selected">
        {count === 0 ? "Press pieces, or draw a box" : `${count} selected`}
      </span>
    </Toolbar>
  );
}
