import type { Point } from "../../api/types";
import { sketchOf, type Drawing } from "../../drawing/drawing";
import { distance, gripAt, pieceAt, POINT_GAP, type Grip } from "../../drawing/piece";
import { changeOf, outlineOf, piecesIn, toggled, withGroups } from "../../drawing/pieces/selection";
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
  /** What is pressed comes to what is selected. */
  readonly adds: boolean;
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
    case "select":
      return placing(drawing, press) ?? framing(drawing, press);
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
    end: () => drawing.finishStroke(),
    cancel: () => drawing.abandon(),
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
    move: (points) => drawing.trace([...stroke, ...points.slice(-1)]),
    end: () => undefined,
    cancel: () => drawing.trace(stroke),
  };
}

function ended(drawing: Drawing, stroke: readonly Point[]): Gesture {
  drawing.trace(stroke);
  drawing.finishStroke();
  return NOTHING;
}

/** Move, scale or turn what is selected by its handles, or select a piece by its line and move it; elsewhere deselect. */
function placing(drawing: Drawing, { point, reach, scale, adds }: Press): Gesture | null {
  const { pieces, selected } = sketchOf(drawing.store.get());
  const outline = outlineOf(drawing.selection);
  const grip = outline && gripAt(frameAt(outline, scale), point, reach);
  if (grip && !adds) return changing(drawing, outline.centre, grip, point);
  const index = pieceAt(pieces, point, reach);
  if (index === null) {
    if (!adds) drawing.select([]);
    return null;
  }
  if (adds) {
    drawing.toggle([index]);
    return NOTHING;
  }
  const isIn = selected.includes(index);
  if (!isIn) drawing.select([index]);
  return changing(drawing, point, "move", point, () => {
    if (isIn) drawing.select([index]);
  });
}

/** Drag a handle of what is selected; `clicked`, where it was pressed and not moved. */
function changing(drawing: Drawing, centre: Point, grip: Grip, from: Point, clicked?: () => void): Gesture {
  let moved = false;
  return {
    move: (points) => {
      const to = points.at(-1);
      if (!to) return;
      moved = true;
      drawing.change(changeOf(centre, grip, from, to));
    },
    end: () => {
      drawing.settle();
      if (!moved) clicked?.();
    },
    cancel: () => drawing.abandon(),
  };
}

/** Draw a box: the pieces that it meets are selected. */
function framing(drawing: Drawing, { point, adds }: Press): Gesture {
  const { pieces, selected } = sketchOf(drawing.store.get());
  const before = adds ? selected : [];
  const back = () => drawing.frame(null);
  return {
    move: (points) => {
      const to = points.at(-1);
      if (!to) return;
      const met = withGroups(pieces, piecesIn(pieces, point, to)).filter((i) => !before.includes(i));
      drawing.select(toggled(before, met));
      drawing.frame([point, to]);
    },
    end: back,
    cancel: () => {
      drawing.select(selected);
      back();
    },
  };
}
