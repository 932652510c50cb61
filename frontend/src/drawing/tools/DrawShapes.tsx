import { Menu } from "@mantine/core";
import { IconShape } from "@tabler/icons-react";
import { useMemo } from "react";
import { usePage } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useService } from "../../ui/services";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { Drawing, returns } from "../drawing";
import { BASIC_SHAPES, basicPiece } from "../library/basic";
import { library } from "../library/references";
import { plannedLines, shapesOf, type Shape } from "../library/shown";
import { pieceOf, type Piece } from "../piece";
import { middleOfReach } from "./DrawText";

/** Common shapes and the library's, placed on the plan as pieces that can be moved, scaled and turned. */
export function DrawShapes() {
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
      const { shape } = plannedLines(await library.reference(name), frequency);
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
            onClick={() => {
              place(basicPiece(shape, middleOfReach(length)), shape.closed);
            }}
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
