import { Menu } from "@mantine/core";
import { IconShape } from "@tabler/icons-react";
import { useMemo } from "react";
import { usePage } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useService } from "../../ui/services";
import { ToolButton } from "../../ui/ToolButton";
import { Drawing, returns } from "../drawing";
import { library } from "../library/references";
import { plannedLines, shapesOf, type Shape } from "../library/shown";
import { pieceOf } from "../piece";

/** The library's shapes, placed on the plan as pieces that can be moved, scaled and turned. */
export function DrawShapes() {
  const drawing = useService(Drawing);
  const operations = useService(Operations);
  const references = usePage((page) => page.references);
  const shapes = useMemo(() => shapesOf(references), [references]);
  const add = ({ name, frequency }: Shape) =>
    operations.attempt("Shape not placed", async () => {
      const { shape } = plannedLines(await library.reference(name), frequency);
      drawing.choose("drag");
      drawing.add([pieceOf(shape)], returns(shape));
      drawing.chooseSource("drawing");
    });
  return (
    <Menu position="bottom-start" shadow="md">
      <Menu.Target>
        <ToolButton label="Place a shape of the library" testId="tool-shape">
          <IconShape size={18} />
        </ToolButton>
      </Menu.Target>
      <Menu.Dropdown mah={300} className="draw-list">
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
