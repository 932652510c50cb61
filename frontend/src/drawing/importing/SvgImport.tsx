import { NativeSelect } from "@mantine/core";
import { useMemo, useState } from "react";
import type { Point } from "../../api/types";
import { usePage } from "../../live/page";
import { plain } from "../../ui/format";
import { pieceOf } from "../piece";
import { middleOfReach } from "../tools/DrawText";
import { ImportFrame, type Found } from "./ImportFrame";
import { PIXEL, type SvgPath } from "./svg";

interface Props {
  readonly file: File;
  readonly path: SvgPath;
  readonly onClose: () => void;
}

const UNITS: readonly (readonly [string, number])[] = [
  ["1 mm", 1],
  ["1 px (1/96 in)", PIXEL],
  ["1 pt (1/72 in)", 25.4 / 72],
  ["1 cm", 10],
  ["1 in", 25.4],
];

/** An SVG file: how large its unit is, if its size does not say it. */
export function SvgImport({ file, path, onClose }: Props) {
  const [unit, setUnit] = useState(path.unit);
  const length = usePage((page) => page.workspace?.length ?? 0.25);
  const found = useMemo(() => foundIn(path, unit ?? 1, middleOfReach(length)), [path, unit, length]);
  const stated =
    path.unit === null ? [] : [[`${plain(path.unit, 4)} mm, as the file says`, path.unit] as const];
  const open = unit === null ? [{ value: "", label: "unit?" }] : [];
  return (
    <ImportFrame
      file={file}
      found={found}
      question={unit === null ? "Say how long a unit is: the file does not" : ""}
      problem=""
      onClose={onClose}
    >
      <NativeSelect
        size="xs"
        w="fit-content"
        label="A unit of the file is"
        data-testid="import-scale"
        error={unit === null}
        value={unit === null ? "" : String(unit)}
        data={[...open, ...[...stated, ...UNITS.filter(([, size]) => size !== path.unit)].map(([label, size]) => ({ value: String(size), label }))]} // prettier-ignore
        onChange={(event) => setUnit(Number(event.currentTarget.value))}
      />
    </ImportFrame>
  );
}

/** The strokes with a unit of `unit` [mm], their common middle at `centre`: a page has no place in the plane. */
function foundIn({ strokes, notes }: SvgPath, unit: number, centre: Point): Found {
  const scale = unit * 1e-3;
  const middle = pieceOf(strokes.flat()).placement.centre;
  const placed = ([x, y]: Point): Point => [(x - middle[0]) * scale + centre[0], (y - middle[1]) * scale + centre[1]]; // prettier-ignore
  const place = `put in the middle of the upper reach: x = ${plain(centre[0] * 1e3, 0)}, y = ${plain(centre[1] * 1e3, 0)} mm`;
  return {
    strokes: strokes.map((stroke) => stroke.map(placed)),
    times: null,
    timesProblem: "",
    rows: null,
    notes: [...notes, place],
  };
}
