import { Divider, Menu } from "@mantine/core";
import {
  IconArrowBackUp,
  IconArrowForwardUp,
  IconCopy,
  IconHandMove,
  IconMarquee2,
  IconPolygon,
  IconScribble,
  IconShape,
  IconTrash,
  IconX,
} from "@tabler/icons-react";
import { useMemo, type ComponentType } from "react";
import { useService } from "../../ui/services";
import { Toolbar } from "../../ui/buttons/Toolbar";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { Drawing, returns, sketchOf, useDrawing, type Tool } from "../drawing";
import { DrawImport } from "../importing/DrawImport";
import { DrawText, middleOfReach } from "./DrawText";
import { usePage } from "../../live/page";
import { Operations } from "../../operate/operations";
import { BASIC_SHAPES, basicPiece } from "../library/basic";
import { library } from "../library/references";
import { drawnShape, shapesOf, type Shape } from "../library/shown";
import { pieceOf, type Piece } from "../piece";

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
      <ToolButton label="Undo (Ctrl Z)" testId="undo" disabled={noPast} onClick={() => drawing.undo()}>
        <IconArrowBackUp size={18} />
      </ToolButton>
      <ToolButton
        label="Redo (Ctrl Shift Z)"
        testId="redo"
        disabled={noFuture}
        onClick={() => drawing.redo()}
      >
        <IconArrowForwardUp size={18} />
      </ToolButton>
      <ToolButton
        label="Duplicate what is selected"
        testId="duplicate"
        disabled={unselected}
        onClick={() => drawing.duplicate()}
      >
        <IconCopy size={18} />
      </ToolButton>
      <ToolButton
        label="Take away what is selected (Del)"
        testId="remove"
        disabled={unselected}
        onClick={() => drawing.remove()}
      >
        <IconX size={18} />
      </ToolButton>
      <ToolButton
        label="Clear the drawing"
        testId="clear-drawing"
        disabled={empty}
        onClick={() => drawing.clear()}
      >
        <IconTrash size={18} />
      </ToolButton>
    </Toolbar>
  );
}

/** Common shapes and the library's, placed on the plan as pieces that can be moved, scaled and turned. */
function DrawShapes() {
  const drawing = useService(Drawing);
  const operations = useService(Operations);
  const references = usePage((page) => page.references);
  const length = usePage((page) => page.workspace?.length ?? 0.25);
  const shapes = useMemo(() => shapesOf(references), [references]);
  const place = (piece: Piece, closed: boolean) => {
    drawing.choose("drag");
    drawing.add([piece], closed);
    drawing.chooseSource("drawing");
  };
  const add = ({ name, frequency }: Shape) =>
    operations.attempt("Shape not placed", async () => {
      const shape = drawnShape(await library.reference(name), frequency);
      place(pieceOf(shape), returns(shape));
    });
  return (
    <Menu position="bottom-start" shadow="md">
      <Menu.Target>
        <ToolButton label="Place a shape" testId="tool-shape">
          <IconShape size={18} />
        </ToolButton>
      </Menu.Target>
      <Menu.Dropdown mah={300} className="draw-list">
        {BASIC_SHAPES.map((shape) => (
          <Menu.Item
            key={shape.label}
            onClick={() => place(basicPiece(shape, middleOfReach(length)), shape.closed)}
          >
            {shape.label}
          </Menu.Item>
        ))}
        <Menu.Label>Of the paper</Menu.Label>
        {shapes.length === 0 ? <Menu.Item disabled>Waiting for the rig</Menu.Item> : null}
        {shapes.map((shape) => (
          <Menu.Item key={shape.name} onClick={() => void add(shape)}>
            {shape.label}
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
