import { FileButton } from "@mantine/core";
import { IconFileImport } from "@tabler/icons-react";
import { useEffect } from "react";
import type { Point } from "../../api/types";
import { PageStore } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useServices, type Services } from "../../ui/services";
import { ToolButton } from "../../ui/ToolButton";
import { Drawing } from "../drawing";
import { pieceOf, type Piece } from "../piece";
import { readPath } from "../readPath";
import { middleOfReach } from "./DrawText";
import { ImportError, parseSvg } from "./svg";

/** Largest file that is read: the page would stand still over a larger one. */
const BYTES_MAX = 2_000_000;

/** A CSV or SVG file becomes a drawing: by this button, or dropped on the page. */
export function DrawImport() {
  const services = useServices();
  useEffect(() => {
    const allow = (event: DragEvent) => {
      event.preventDefault();
    };
    const drop = (event: DragEvent) => {
      event.preventDefault();
      void read(event.dataTransfer?.files.item(0) ?? null, services);
    };
    window.addEventListener("dragover", allow);
    window.addEventListener("drop", drop);
    return () => {
      window.removeEventListener("dragover", allow);
      window.removeEventListener("drop", drop);
    };
  }, [services]);
  const label = "Import a CSV (t, x, y or x, y) or an SVG path in mm; or drop the file here";
  return (
    <FileButton
      accept=".csv,.txt,.svg,text/csv,image/svg+xml"
      inputProps={{ "aria-label": "File to import" }}
      onChange={(file) => void read(file, services)}
    >
      {(button) => (
        <ToolButton {...button} label={label} testId="tool-import">
          <IconFileImport size={18} />
        </ToolButton>
      )}
    </FileButton>
  );
}

async function read(file: File | null, services: Services): Promise<void> {
  if (!file) return;
  const [drawing, operations] = [services.get(Drawing), services.get(Operations)];
  await operations.attempt(`${file.name} not imported`, async () => {
    if (file.size > BYTES_MAX)
      throw new ImportError(
        `The file has ${file.size} bytes, more than ${BYTES_MAX}: a path needs far fewer`,
      );
    const text = await file.text();
    const isSvg = file.name.toLowerCase().endsWith(".svg") || text.trimStart().startsWith("<");
    const pieces = isSvg
      ? outlines(text, middleOfReach(services.get(PageStore).get().workspace?.length ?? 0.25))
      : [await fromCsv(file, operations)];
    drawing.choose("drag");
    drawing.add(pieces);
    if (pieces[0].times) drawing.follow({ timing: { kind: "given" } });
    drawing.chooseSource("drawing");
  });
}

/** A CSV file, as the server reads it, is in the plane's own frame: it stays where it says. */
async function fromCsv(file: File, operations: Operations): Promise<Piece> {
  const { points, times, notes } = await readPath(file);
  if (notes.length > 0) operations.notify("info", `${file.name} imported`, notes.join("; "));
  return pieceOf(points, times);
}

/** The strokes of an SVG file, their common middle put at `centre`: its page has no place in the plane. */
function outlines(text: string, centre: Point): Piece[] {
  const strokes = parseSvg(text);
  const middle = pieceOf(strokes.flat()).placement.centre;
  return strokes.map((stroke) =>
    pieceOf(stroke.map(([x, y]): Point => [x - middle[0] + centre[0], y - middle[1] + centre[1]])),
  );
}
