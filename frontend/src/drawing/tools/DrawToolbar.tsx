import { Divider } from "@mantine/core";
import {
  IconArrowBackUp,
  IconArrowForwardUp,
  IconCopy,
  IconHandMove,
  IconMarquee2,
  IconPolygon,
  IconScribble,
  IconTrash,
  IconX,
} from "@tabler/icons-react";
import type { ComponentType } from "react";
import { useService } from "../../ui/services";
import { Toolbar } from "../../ui/buttons/Toolbar";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { Drawing, sketchOf, useDrawing, type Tool } from "../drawing";
import { DrawImport } from "../importing/DrawImport";
import { DrawShapes } from "./DrawShapes";
import { DrawText } from "./DrawText";

type Icon = ComponentType<{ size: number }>;

const TOOLS: readonly (readonly [Tool, string, Icon])[] = [
  ["drag", "Drag the target, and the drawing's handles", IconHandMove],
  ["select", "Select: press pieces, or draw a box around them", IconMarquee2],
  ["freehand", "Draw freehand", IconScribble],
  ["polyline", "Draw straight lines: click points, double-click or Enter ends", IconPolygon],
];

/** What the pointer does on the plan, and what can be done to the drawing. */
export function DrawToolbar() {
  const drawing = useService(Drawing);
  const tool = useDrawing((state) => state.tool);
  const empty = useDrawing((state) => sketchOf(state).pieces.length === 0);
  const unselected = useDrawing((state) => sketchOf(state).selected.length === 0);
  const noPast = useDrawing(({ history }) => history.past.length === 0);
  const noFuture = useDrawing(({ history }) => history.future.length === 0);
  return (
    <Toolbar className="draw-bar" label="Drawing">
      {TOOLS.map(([name, meaning, Picture]) => (
        <ToolButton
          key={name}
          label={meaning}
          testId={`tool-${name}`}
          pressed={tool === name}
          onClick={() => {
            drawing.choose(name);
            if (name !== "drag") drawing.chooseSource("drawing");
          }}
        >
          <Picture size={18} />
        </ToolButton>
      ))}
      <DrawShapes />
      <DrawText />
      <DrawImport />
      <Divider orientation="vertical" mx={2} />
      <ToolButton
        label="Undo (Ctrl Z)"
        testId="undo"
        disabled={noPast}
        onClick={() => {
          drawing.undo();
        }}
      >
        <IconArrowBackUp size={18} />
      </ToolButton>
      <ToolButton
        label="Redo (Ctrl Shift Z)"
        testId="redo"
        disabled={noFuture}
        onClick={() => {
          drawing.redo();
        }}
      >
        <IconArrowForwardUp size={18} />
      </ToolButton>
      <ToolButton
        label="Duplicate what is selected"
        testId="duplicate"
        disabled={unselected}
        onClick={() => {
          drawing.duplicate();
        }}
      >
        <IconCopy size={18} />
      </ToolButton>
      <ToolButton
        label="Take away what is selected (Del)"
        testId="remove"
        disabled={unselected}
        onClick={() => {
          drawing.remove();
        }}
      >
        <IconX size={18} />
      </ToolButton>
      <ToolButton
        label="Clear the drawing"
        testId="clear-drawing"
        disabled={empty}
        onClick={() => {
          drawing.clear();
        }}
      >
        <IconTrash size={18} />
      </ToolButton>
    </Toolbar>
  );
}
