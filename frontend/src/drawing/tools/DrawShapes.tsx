import { Menu } from "@mantine/core";
import { IconShape } from "@tabler/icons-react";
import { useMemo } from "react";
import { rest } from "../../api/rest";
import { plannedLines } from "../../plan/paint/planned";
import { returns } from "../drawing";
import { pieceOf } from "../piece";
import { shapesOf, type Shape } from "../library/shapes";
import { ToolButton } from "../../ui/ToolButton";
import { useDashboard, usePage } from "../../ui/context";

/** The library's shapes, placed on the plan as pieces that can be moved, scaled and turned. */
export function DrawShapes() {
  const { drawing, operations, runs } = useDashboard();
  const references = usePage((page) => page.references);
  const shapes = useMemo(() => shapesOf(references), [references]);
  const add = ({ name, frequency }: Shape) =>
    operations.attempt("Shape not placed", async () => {
      const { shape } = plannedLines(await rest.reference(name), frequency);
      drawing.choose("drag");
      drawing.add([pieceOf(shape)], returns(shape));
      runs.choose("drawing");
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
