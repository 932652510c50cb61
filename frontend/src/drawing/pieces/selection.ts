import type { Point } from "../../api/types";
import {
  bearing,
  distance,
  halfSize,
  place,
  placed,
  SCALE_MAX,
  SCALE_MIN,
  type Grip,
  type Outline,
  type Piece,
} from "../piece";

/** How what is selected is to lie: scaled and turned about a place [m], then shifted [m]. */
export interface Change {
  readonly about: Point;
  readonly shift: Point;
  readonly angle: number;
  readonly scale: number;
}

/** Of one piece the box that turns with it, of several an upright one around all; null around nothing. */
export function outlineOf(pieces: readonly Piece[]): Outline | null {
  if (pieces.length === 0) return null;
  if (pieces.length === 1) {
    const { centre, angle } = pieces[0].placement;
    return { centre, half: halfSize(pieces[0]), angle };
  }
  let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const piece of pieces)
    for (const [x, y] of placed(piece)) {
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
    }
  return {
    centre: [(left + right) / 2, (bottom + top) / 2],
    half: [(right - left) / 2, (top - bottom) / 2],
    angle: 0,
  };
}

/** What dragging a handle of the box about `centre` from `from` to `to` [m] asks for. */
export function changeOf(centre: Point, grip: Grip, from: Point, to: Point): Change {
  const still: Change = { about: centre, shift: [0, 0], angle: 0, scale: 1 };
  switch (grip) {
    case "move":
      return { ...still, shift: [to[0] - from[0], to[1] - from[1]] };
    case "scale":
      return { ...still, scale: distance(centre, to) / distance(centre, from) };
    case "turn":
      return { ...still, angle: bearing(centre, to) - bearing(centre, from) };
  }
}

/** The same change, but that none of `pieces` becomes smaller or larger than a piece may be. */
export function bounded(change: Change, pieces: readonly Piece[]): Change {
  if (!Number.isFinite(change.scale)) return { ...change, scale: 1 };
  const scales = pieces.map(({ placement }) => placement.scale);
  const least = Math.min(1, SCALE_MIN / Math.min(...scales));
  const most = Math.max(1, SCALE_MAX / Math.max(...scales));
  return { ...change, scale: Math.min(most, Math.max(least, change.scale)) };
}

/** `pieces` with those at the indices `which` changed as one. */
export function changed(pieces: readonly Piece[], which: readonly number[], change: Change): Piece[] {
  const picked = new Set(which);
  return pieces.map((piece, i) => (picked.has(i) ? changedPiece(piece, change) : piece));
}

/** The box after the same change. */
export function changedOutline({ centre, half, angle }: Outline, change: Change): Outline {
  const { scale } = change;
  return {
    centre: moved(centre, change),
    half: [half[0] * scale, half[1] * scale],
    angle: angle + change.angle,
  };
}

/** The pieces at `which` and those that are in a group with one of them, rising. */
export function withGroups(pieces: readonly Piece[], which: readonly number[]): number[] {
  const picked = new Set(which);
  const groups = new Set(which.flatMap((i) => pieces[i].group ?? []));
  return [...pieces.keys()].filter((i) => picked.has(i) || groups.has(pieces[i].group ?? -1));
}

/** Either set of indices, without those that are in both: rising. */
export function toggled(selected: readonly number[], which: readonly number[]): number[] {
  const isIn = which.every((i) => selected.includes(i));
  const rest = selected.filter((i) => !which.includes(i));
  return isIn ? rest : [...rest, ...which].sort((a, b) => a - b);
}

/** A number that no group has. */
export function freeGroup(pieces: readonly Piece[]): number {
  return 1 + pieces.reduce((most, { group }) => Math.max(most, group ?? 0), 0);
}

/** `pieces` that come to `others`: grouped as they are, but in no group of theirs. */
export function apartFrom(others: readonly Piece[], pieces: readonly Piece[]): Piece[] {
  const first = freeGroup(others);
  const groups = [...new Set(pieces.flatMap(({ group }) => group ?? []))];
  return pieces.map((piece) => ({
    ...piece,
    group: piece.group === null ? null : first + groups.indexOf(piece.group),
  }));
}

/** The pieces whose line is in the box between two corners [m], or passes through it; with their groups. */
export function piecesIn(pieces: readonly Piece[], [x0, y0]: Point, [x1, y1]: Point): number[] {
  const [low, high] = [[Math.min(x0, x1), Math.min(y0, y1)], [Math.max(x0, x1), Math.max(y0, y1)]] as const; // prettier-ignore
  const isIn = (piece: Piece) => {
    const points = placed(piece);
    return points.some((end, i) => meetsBox(points[Math.max(0, i - 1)], end, low, high));
  };
  return withGroups(pieces, [...pieces.keys()].filter((i) => isIn(pieces[i]))); // prettier-ignore
}

function changedPiece(piece: Piece, change: Change): Piece {
  const { centre, angle, scale } = piece.placement;
  const placement = {
    centre: moved(centre, change),
    angle: angle + change.angle,
    scale: scale * change.scale,
  };
  return { ...piece, placement };
}

function moved([x, y]: Point, { about, shift, angle, scale }: Change): Point {
  const to: Point = [about[0] + shift[0], about[1] + shift[1]];
  return place({ centre: to, angle, scale }, [x - about[0], y - about[1]]);
}

/** Whether the line from `start` to `end` meets the box: what is left of it between each pair of sides (Liang, Barsky). */
function meetsBox(start: Point, end: Point, low: readonly number[], high: readonly number[]): boolean {
  let [from, to] = [0, 1];
  for (const axis of [0, 1]) {
    const way = end[axis] - start[axis];
    if (way === 0) {
      if (start[axis] < low[axis] || start[axis] > high[axis]) return false;
      continue;
    }
    const cuts = [(low[axis] - start[axis]) / way, (high[axis] - start[axis]) / way];
    from = Math.max(from, Math.min(...cuts));
    to = Math.min(to, Math.max(...cuts));
  }
  return from <= to;
}
