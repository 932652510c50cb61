import type { Placement } from "../state/drawingPiece";
import { halfSize } from "../state/drawingPiece";
import { sketchOf, type DrawingState } from "../state/drawing";
import { DrawNumber } from "./DrawNumber";
import { useDashboard } from "./context";
import { useDrawing } from "./useDrawing";

const DEGREE = Math.PI / 180;

function selectedPiece(state: DrawingState) {
  const { pieces, selected } = sketchOf(state);
  return selected === null ? null : (pieces.at(selected) ?? null);
}

/** Place, size and turn of the selected piece, for those who do not drag its handles. */
export function DrawPlace() {
  const { drawing } = useDashboard();
  const piece = useDrawing(selectedPiece);
  const index = useDrawing((state) => sketchOf(state).selected);
  if (!piece || index === null) return null;
  const { centre, angle, scale } = piece.placement;
  const half = Math.max(...halfSize(piece));
  const put = (change: Partial<Placement>) => {
    drawing.place(index, { ...piece.placement, ...change });
    drawing.settle();
  };
  return (
    <div className="row row-fields" role="group" aria-label="Selected piece">
      <DrawNumber
        label="x [mm]"
        testId="piece-x"
        width={76}
        min={-2000}
        max={2000}
        step={1}
        value={tenths(centre[0] * 1e3)}
        onChange={(x) => {
          put({ centre: [x / 1e3, centre[1]] });
        }}
      />
      <DrawNumber
        label="y [mm]"
        testId="piece-y"
        width={76}
        min={-2000}
        max={2000}
        step={1}
        value={tenths(centre[1] * 1e3)}
        onChange={(y) => {
          put({ centre: [centre[0], y / 1e3] });
        }}
      />
      <DrawNumber
        label="Size [mm]"
        testId="piece-size"
        width={76}
        min={1}
        max={2000}
        step={1}
        value={tenths(2 * half * 1e3)}
        onChange={(size) => {
          put({ scale: (scale * size) / (2 * half * 1e3) });
        }}
      />
      <DrawNumber
        label="Turn [°]"
        testId="piece-turn"
        width={76}
        min={-360}
        max={360}
        step={5}
        value={tenths(angle / DEGREE)}
        onChange={(turn) => {
          put({ angle: turn * DEGREE });
        }}
      />
    </div>
  );
}

function tenths(value: number): number {
  return Math.round(value * 10) / 10;
}
