import type { Point } from "../api/types";

/** Where a piece lies in the plane: its middle [m], its turn [rad, counter-clockwise] and its size against the shape. */
export interface Placement {
  readonly centre: Point;
  readonly angle: number;
  readonly scale: number;
}

/** One stroke of a drawing: a shape about its own middle [m], and where it lies. */
export interface Piece {
  readonly shape: readonly Point[];
  readonly placement: Placement;
  /** When each point is reached [s], where the drawing came with times. */
  readonly times: readonly number[] | null;
  /** Pieces with the same number are selected together. */
  readonly group: number | null;
}

/** The box around what is selected: its middle [m], half its width and height [m], and its turn [rad]. */
export interface Outline {
  readonly centre: Point;
  readonly half: Point;
  readonly angle: number;
}

/** Its corners with some room, and the handle that turns it. */
export interface Frame {
  /** Lower left, lower right, upper right, upper left, as they were before the turn. */
  readonly corners: readonly [Point, Point, Point, Point];
  readonly turn: Point;
  readonly centre: Point;
}

export type Grip = "move" | "scale" | "turn";

/** Most points of a drawing that the server takes. */
export const POINTS_MAX = 5000;
/** Points nearer to the last than this say nothing [m]. */
export const POINT_GAP = 2e-4;
export const SCALE_MIN = 0.02;
export const SCALE_MAX = 50;

export function pieceOf(points: readonly Point[], times: readonly number[] | null = null): Piece {
  const centre = middleOf(points);
  const shape = points.map(([x, y]): Point => [x - centre[0], y - centre[1]]);
  return { shape, placement: { centre, angle: 0, scale: 1 }, times, group: null };
}

/** The piece's points in the plane. */
export function placed({ shape, placement }: Piece): Point[] {
  return shape.map((point) => place(placement, point));
}

/** Half of the piece's width and height as it lies, before it is turned [m]. */
export function halfSize({ shape, placement }: Piece): Point {
  const width = Math.max(...shape.map(([x]) => Math.abs(x)));
  const height = Math.max(...shape.map(([, y]) => Math.abs(y)));
  return [width * placement.scale, height * placement.scale];
}

/** The frame `margin` [m] away from an outline; the turning handle stands `arm` [m] above it. */
export function frameOf({ centre, half, angle }: Outline, margin: number, arm: number): Frame {
  const [x, y] = [half[0] + margin, half[1] + margin];
  const at = (px: number, py: number) => place({ centre, angle, scale: 1 }, [px, py]);
  return { corners: [at(-x, -y), at(x, -y), at(x, y), at(-x, y)], turn: at(0, y + arm), centre };
}

/** The handle within `reach` [m] of `point`. */
export function gripAt({ corners, turn, centre }: Frame, point: Point, reach: number): Grip | null {
  const near = (handle: Point) => distance(handle, point) <= reach;
  if (near(turn)) return "turn";
  if (corners.some(near)) return "scale";
  return near(centre) ? "move" : null;
}

/** The piece whose line passes within `reach` [m] of `point`; the newest where several do. */
export function pieceAt(pieces: readonly Piece[], point: Point, reach: number): number | null {
  const index = pieces.findLastIndex((piece) => passesNear(placed(piece), point, reach));
  return index < 0 ? null : index;
}

/** All pieces as one path, without points that repeat the last. */
export function pathOf(pieces: readonly Piece[]): Point[] {
  const path: Point[] = [];
  for (const piece of pieces)
    for (const point of placed(piece)) {
      const last = path.at(-1);
      if (!last || distance(last, point) > 1e-9) path.push(point);
    }
  return path;
}

/** The stretches of points that are `marked`, each begun one point earlier so that it is seen. */
export function stretches(points: readonly Point[], marked: (index: number) => boolean): Point[][] {
  const found: Point[][] = [];
  for (let i = 0; i < points.length; i++) {
    if (!marked(i)) continue;
    if (i === 0 || !marked(i - 1)) found.push(points.slice(Math.max(0, i - 1), i));
    found[found.length - 1].push(points[i]);
  }
  return found;
}

/** At most `most` of the values, evenly chosen, first and last among them. */
export function thinned<T>(values: readonly T[], most: number): T[] {
  if (values.length <= most) return [...values];
  const step = (values.length - 1) / (most - 1);
  return Array.from({ length: most }, (_, i) => values[Math.round(i * step)]);
}

export function isSamePlace(a: Placement, b: Placement): boolean {
  return distance(a.centre, b.centre) < 1e-9 && a.angle === b.angle && a.scale === b.scale;
}

export function distance(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

/** The point of the plane that a point of the shape becomes. */
export function place({ centre, angle, scale }: Placement, [x, y]: Point): Point {
  const [c, s] = [scale * Math.cos(angle), scale * Math.sin(angle)];
  return [centre[0] + c * x - s * y, centre[1] + s * x + c * y];
}

/** The point of the shape that a point of the plane was. */
export function unplaced({ centre, angle, scale }: Placement, [x, y]: Point): Point {
  const [c, s] = [Math.cos(angle) / scale, Math.sin(angle) / scale];
  const [dx, dy] = [x - centre[0], y - centre[1]];
  return [c * dx + s * dy, c * dy - s * dx];
}

function middleOf(points: readonly Point[]): Point {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [(Math.min(...xs) + Math.max(...xs)) / 2, (Math.min(...ys) + Math.max(...ys)) / 2];
}

export function bearing(from: Point, to: Point): number {
  return Math.atan2(to[1] - from[1], to[0] - from[0]);
}

function passesNear(points: readonly Point[], point: Point, reach: number): boolean {
  return points.some((end, i) => distanceToSegment(point, points[Math.max(0, i - 1)], end) <= reach);
}

function distanceToSegment(point: Point, start: Point, end: Point): number {
  const [dx, dy] = [end[0] - start[0], end[1] - start[1]];
  const square = dx * dx + dy * dy;
  const along = square === 0 ? 0 : ((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / square;
  const share = Math.min(1, Math.max(0, along));
  return distance(point, [start[0] + share * dx, start[1] + share * dy]);
}
