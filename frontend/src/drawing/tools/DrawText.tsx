import { Button, NumberInput, Popover, TextInput } from "@mantine/core";
import { IconTypography } from "@tabler/icons-react";
import { useState } from "react";
import { api, dataOf } from "../../api/rest";
import type { Point } from "../../api/types";
import { usePage } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useService } from "../../ui/services";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { Drawing } from "../drawing";
import { pieceOf, type Piece } from "../piece";
import { changed, outlineOf } from "../pieces/selection";

/** Type a word: it stands on the plan in strokes that are one group. */
export function DrawText() {
  const drawing = useService(Drawing);
  const operations = useService(Operations);
  const length = usePage((page) => page.workspace?.length ?? 0.25);
  const [opened, setOpened] = useState(false);
  const [text, setText] = useState("");
  const [height, setHeight] = useState<number | string>(30);
  const place = () =>
    operations.attempt("Text not placed", async () => {
      const body = { text, height: Number(height) / 1e3 };
      const { strokes } = await dataOf(api.POST("/api/drawings/text", { body }));
      drawing.choose("drag");
      drawing.add(asOne(strokes, middleOfReach(length)));
      drawing.chooseSource("drawing");
      setOpened(false);
    });
  return (
    <Popover opened={opened} onChange={setOpened} position="bottom-start" shadow="md" trapFocus>
      <Popover.Target>
        <ToolButton label="Write text" testId="tool-text" onClick={() => setOpened(!opened)}>
          <IconTypography size={18} />
        </ToolButton>
      </Popover.Target>
      <Popover.Dropdown>
        <form
          className="row row-fields"
          onSubmit={(event) => {
            event.preventDefault();
            if (text.trim() !== "") void place();
          }}
        >
          <TextInput
            size="xs"
            w={130}
            label="Text"
            maxLength={40}
            data-testid="text"
            value={text}
            onChange={(event) => setText(event.currentTarget.value)}
          />
          <NumberInput
            size="xs"
            w={90}
            label="Height [mm]"
            min={1}
            max={200}
            value={height}
            onChange={setHeight}
          />
          <Button size="xs" type="submit" variant="default" data-testid="text-place">
            Place
          </Button>
        </form>
      </Popover.Dropdown>
    </Popover>
  );
}

/** The strokes as one group with its middle at `centre`. */
function asOne(strokes: readonly (readonly Point[])[], centre: Point): Piece[] {
  const pieces = strokes.map((stroke) => ({ ...pieceOf(stroke), group: strokes.length > 1 ? 1 : null }));
  const outline = outlineOf(pieces);
  const from = outline?.centre ?? centre;
  const shift: Point = [centre[0] - from[0], centre[1] - from[1]];
  return changed(pieces, [...pieces.keys()], { about: from, shift, angle: 0, scale: 1 });
}

/** Where the library places its shapes, for an actuator of this length [m]. */
export function middleOfReach(length: number): Point {
  return [0.12 * length, 0.55 * length];
}
