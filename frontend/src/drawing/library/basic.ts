import type { Point } from "../../api/types";
import { pieceOf, type Piece } from "../piece";

/** A shape that everyone knows, as large as the paper's circle. */
export interface BasicShape {
  readonly label: string;
  /** It leads back to where it begins. */
  readonly closed: boolean;
  /** Its points about its middle [m]. */
  readonly points: () => Point[];
}

const RADIUS = 0.03;
const AROUND = 180;
const TURNS = 3;
const ROWS = 7;

export const BASIC_SHAPES: readonly BasicShape[] = [
  { label: "Square", closed: true, points: () => polygon(4, Math.PI / 4) },
  { label: "Triangle", closed: true, points: () => polygon(3, Math.PI / 2) },
  { label: "Star", closed: true, points: star },
  { label: "Ellipse", closed: true, points: () => curve((phase) => [Math.cos(phase), 0.6 * Math.sin(phase)]) },
  { label: "Figure eight", closed: true, points: () => curve((phase) => [Math.sin(phase), 0.5 * Math.sin(2 * phase)]) },
  { label: "Spiral", closed: false, points: spiral },
  { label: "Raster", closed: false, points: raster },
]; // prettier-ignore

/** The shape with its middle at `centre` [m]. */
export function basicPiece(shape: BasicShape, centre: Point): Piece {
  const piece = pieceOf(shape.points());
  return { ...piece, placement: { ...piece.placement, centre } };
}

/** Corners on a circle, counter-clockwise, the first at the angle `first` [rad]. */
function polygon(corners: number, first: number): Point[] {
  return Array.from({ length: corners }, (_, i) => onCircle(RADIUS, first + (2 * Math.PI * i) / corners));
}

/** Five points up, each seen past two others: the inner corners of a pentagram. */
function star(): Point[] {
  const inner = RADIUS * Math.cos((2 * Math.PI) / 5) / Math.cos(Math.PI / 5); // prettier-ignore
  return Array.from({ length: 10 }, (_, i) =>
    onCircle(i % 2 === 0 ? RADIUS : inner, Math.PI / 2 + (Math.PI * i) / 5),
  );
}

/** Once around in units of the radius. */
function curve(at: (phase: number) => Point): Point[] {
  return Array.from({ length: AROUND }, (_, i) => {
    const [x, y] = at((2 * Math.PI * i) / AROUND);
    return [RADIUS * x, RADIUS * y];
  });
}

/** From the middle outwards, evenly apart. */
function spiral(): Point[] {
  const count = TURNS * AROUND;
  return Array.from({ length: count + 1 }, (_, i) =>
    onCircle((RADIUS * i) / count, (2 * Math.PI * i) / AROUND),
  );
}

/** Rows of a square there and back, from the lower left. */
function raster(): Point[] {
  const half = RADIUS * Math.SQRT1_2;
  return Array.from({ length: 2 * ROWS }, (_, i) => {
    const row = Math.floor(i / 2);
    const right = i % 2 === 1 ? row % 2 === 0 : row % 2 === 1;
    return [right ? half : -half, -half + (2 * half * row) / (ROWS - 1)];
  });
}

function onCircle(radius: number, angle: number): Point {
  return [radius * Math.cos(angle), radius * Math.sin(angle)];
}
