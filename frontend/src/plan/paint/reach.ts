import type { Point, Workspace } from "../../api/types";

export type Quad = readonly [Point, Point, Point, Point];

/** Quads between neighbouring points of the workspace's grid. */
export function reachQuads(workspace: Workspace): Quad[] {
  const { rows, columns, points } = workspace;
  const quads: Quad[] = [];
  for (let row = 0; row + 1 < rows; row++)
    for (let column = 0; column + 1 < columns; column++) {
      const first = row * columns + column;
      const above = first + columns;
      quads.push(counterClockwise([points[first], points[first + 1], points[above + 1], points[above]]));
    }
  return quads;
}

/** Where the map folds over, quads turn the other way round; turned alike, they all fill under the non-zero rule. */
export function counterClockwise(quad: Quad): Quad {
  const [a, b, c, d] = quad;
  return signedArea(quad) < 0 ? [d, c, b, a] : quad;
}

export function signedArea([a, b, c, d]: Quad): number {
  return ((c[0] - a[0]) * (d[1] - b[1]) - (d[0] - b[0]) * (c[1] - a[1])) / 2;
}

/** Convex hull, counter-clockwise (monotone chain): what inside it is not reach is the hole. */
export function hull(points: readonly Point[]): Point[] {
  const sorted = points.toSorted((a, b) => a[0] - b[0] || a[1] - b[1]);
  const lower = chain(sorted);
  const upper = chain(sorted.toReversed());
  return [...lower.slice(0, -1), ...upper.slice(0, -1)];
}

function chain(sorted: readonly Point[]): Point[] {
  const kept: Point[] = [];
  for (const point of sorted) {
    while (kept.length >= 2 && turn(kept[kept.length - 2], kept[kept.length - 1], point) <= 0) kept.pop();
    kept.push(point);
  }
  return kept;
}

function turn(a: Point, b: Point, c: Point): number {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}
