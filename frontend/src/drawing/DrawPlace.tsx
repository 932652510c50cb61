import { useService } from "../ui/services";
import { Drawing, selectionOf, sketchOf, useDrawing } from "./drawing";
import { DrawNumber } from "./DrawNumber";
import type { Outline } from "./piece";
import { outlineOf, type Change } from "./pieces/selection";

interface Field {
  readonly label: string;
  readonly testId: string;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  /** The number shown for what is selected. */
  readonly read: (outline: Outline) => number;
  /** What has to change to show `value` instead. */
  readonly put: (outline: Outline, value: number) => Partial<Change>;
}

const DEGREE = Math.PI / 180;
const PLACE = { min: -2000, max: 2000, step: 1 };

const FIELDS: readonly Field[] = [
  {
    ...{ label: "x [mm]", testId: "piece-x", ...PLACE },
    read: ({ centre }) => centre[0] * 1e3,
    put: ({ centre }, x) => ({ shift: [x / 1e3 - centre[0], 0] }),
  },
  {
    ...{ label: "y [mm]", testId: "piece-y", ...PLACE },
    read: ({ centre }) => centre[1] * 1e3,
    put: ({ centre }, y) => ({ shift: [0, y / 1e3 - centre[1]] }),
  },
  {
    ...{ label: "Size [mm]", testId: "piece-size", min: 1, max: 2000, step: 1 },
    read: sizeOf,
    put: (outline, size) => ({ scale: size / sizeOf(outline) }),
  },
];

/** Only one piece has a turn of its own. */
const TURN: Field = {
  ...{ label: "Turn [°]", testId: "piece-turn", min: -360, max: 360, step: 5 },
  read: ({ angle }) => angle / DEGREE,
  put: ({ angle }, turn) => ({ angle: turn * DEGREE - angle }),
};

/** Place, size and turn of what is selected, for those who do not drag its handles. */
export function DrawPlace() {
  const drawing = useService(Drawing);
  const sketch = useDrawing(sketchOf);
  const selection = selectionOf(sketch);
  const outline = outlineOf(selection);
  if (!outline) return null;
  const fields = selection.length === 1 ? [...FIELDS, TURN] : FIELDS;
  return (
    <div
      className="row row-fields"
      role="group"
      aria-label={selection.length === 1 ? "Selected piece" : `${selection.length} selected pieces`}
    >
      {fields.map(({ read, put, ...field }) => (
        <DrawNumber
          key={field.testId}
          {...field}
          width={76}
          value={tenths(read(outline))}
          onChange={(value) => {
            const still: Change = { about: outline.centre, shift: [0, 0], angle: 0, scale: 1 };
            drawing.change({ ...still, ...put(outline, value) });
            drawing.settle();
          }}
        />
      ))}
    </div>
  );
}

/** The longer side [mm]. */
function sizeOf({ half }: Outline): number {
  return 2e3 * Math.max(...half);
}

function tenths(value: number): number {
  return Math.round(value * 10) / 10;
}
