import type { Point } from "../../api/types";
import { sketchOf, type Drawing } from "../../drawing/drawing";
import { distance, dragged, gripAt, pieceAt, POINT_GAP } from "../../drawing/piece";
import { frameAt } from "../paint/handles";

/** A press on the plan and what follows it, in points of the plane [m]. */
export interface Gesture {
  move(points: readonly Point[]): void;
  end(): void;
  /** The press became something else, as a second finger makes it a pinch. */
  cancel(): void;
}

/** Where the plan was pressed: the point [m], how near counts as a hit [m], and the picture's scale [px/m]. */
export interface Press {
  readonly point: Point;
  readonly reach: number;
  readonly scale: number;
}

const NOTHING: Gesture = { move: () => undefined, end: () => undefined, cancel: () => undefined };

/** What the chosen tool makes of a press; null: nothing of the drawing is there. */
export function gestureOf(drawing: Drawing, press: Press): Gesture | null {
  switch (drawing.store.get().tool) {
    case "freehand":
      return freehand(drawing, press.point);
    case "polyline":
      return corner(drawing, press);
    case "drag":
      return placing(drawing, press);
  }
}

function freehand(drawing: Drawing, start: Point): Gesture {
  const stroke = [start];
  drawing.trace([start]);
  return {
    move: (points) => {
      if (drawing.store.get().stroke.length === 0) return; // Esc has abandoned it
      for (const point of points)
        if (distance(stroke[stroke.length - 1], point) > POINT_GAP) stroke.push(point);
      drawing.trace([...stroke]);
    },
    end: () => {
      drawing.finishStroke();
    },
    cancel: () => {
      drawing.abandon();
    },
  };
}

/** A corner where it is pressed, until let go; pressed on the last corner or the first, it ends the stroke. */
function corner(drawing: Drawing, { point, reach }: Press): Gesture {
  const { stroke } = drawing.store.get();
  const [first, last] = [stroke.at(0), stroke.at(-1)];
  if (first && stroke.length > 2 && distance(first, point) <= reach)
    return ended(drawing, [...stroke, first]);
  if (last && stroke.length > 1 && distance(last, point) <= reach) return ended(drawing, stroke);
  drawing.trace([...stroke, point]);
  return {
    move: (points) => {
      drawing.trace([...stroke, ...points.slice(-1)]);
    },
    end: () => undefined,
    cancel: () => {
      drawing.trace(stroke);
    },
  };
}

function ended(drawing: Drawing, stroke: readonly Point[]): Gesture {
  drawing.trace(stroke);
  drawing.finishStroke();
  return NOTHING;
}

/** Move, scale or turn the selected piece by its handles, or move any piece by its line; elsewhere deselect. */
function placing(drawing: Drawing, { point, reach, scale }: Press): Gesture | null {
  const { pieces, selected } = sketchOf(drawing.store.get());
  const piece = drawing.selectedPiece;
  const grip = piece && gripAt(frameAt(piece, scale), point, reach);
  const index = grip ? selected : pieceAt(pieces, point, reach);
  drawing.select(index);
  if (index === null) return null;
  const { placement } = pieces[index];
  return {
    move: (points) => {
      const to = points.at(-1);
      if (to) drawing.place(index, dragged(placement, grip ?? "move", point, to));
    },
    end: () => {
      drawing.settle();
    },
    cancel: () => {
      drawing.abandon();
    },
  };
}
