import { useService } from "../ui/services";
import { Drawing, sketchOf, useDrawing, type DrawingState } from "./drawing";
import { DrawNumber } from "./DrawNumber";
import type { Piece, Placement } from "./piece";
import { halfSize } from "./piece";

interface Field {
  readonly label: string;
  readonly testId: string;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  /** The number shown for a piece. */
  readonly read: (piece: Piece) => number;
  /** What changes in its placement to show `value` instead. */
  readonly put: (piece: Piece, value: number) => Partial<Placement>;
}

const DEGREE = Math.PI / 180;
const PLACE = { min: -2000, max: 2000, step: 1 };

const FIELDS: readonly Field[] = [
  {
    ...{ label: "x [mm]", testId: "piece-x", ...PLACE },
    read: ({ placement }) => placement.centre[0] * 1e3,
    put: ({ placement }, x) => ({ centre: [x / 1e3, placement.centre[1]] }),
  },
  {
    ...{ label: "y [mm]", testId: "piece-y", ...PLACE },
    read: ({ placement }) => placement.centre[1] * 1e3,
    put: ({ placement }, y) => ({ centre: [placement.centre[0], y / 1e3] }),
  },
  {
    ...{ label: "Size [mm]", testId: "piece-size", min: 1, max: 2000, step: 1 },
    read: sizeOf,
    put: (piece, size) => ({ scale: (piece.placement.scale * size) / sizeOf(piece) }),
  },
  {
    ...{ label: "Turn [°]", testId: "piece-turn", min: -360, max: 360, step: 5 },
    read: ({ placement }) => placement.angle / DEGREE,
    put: (_, turn) => ({ angle: turn * DEGREE }),
  },
];

/** Place, size and turn of the selected piece, for those who do not drag its handles. */
export function DrawPlace() {
  const drawing = useService(Drawing);
  const piece = useDrawing(selectedPiece);
  const index = useDrawing((state) => sketchOf(state).selected);
  if (!piece || index === null) return null;
  return (
    <div className="row row-fields" role="group" aria-label="Selected piece">
      {FIELDS.map(({ read, put, ...field }) => (
        <DrawNumber
          key={field.testId}
          {...field}
          width={76}
          value={tenths(read(piece))}
          onChange={(value) => {
            drawing.place(index, { ...piece.placement, ...put(piece, value) });
            drawing.settle();
          }}
        />
      ))}
    </div>
  );
}

function selectedPiece(state: DrawingState): Piece | null {
  const { pieces, selected } = sketchOf(state);
  return selected === null ? null : (pieces.at(selected) ?? null);
}

/** The longer side of a piece [mm]. */
function sizeOf(piece: Piece): number {
  return 2e3 * Math.max(...halfSize(piece));
}

function tenths(value: number): number {
  return Math.round(value * 10) / 10;
}
