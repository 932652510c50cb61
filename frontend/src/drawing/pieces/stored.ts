import type { DrawingBody, Point } from "../../api/types";
import { placed, POINTS_MAX, thinned, unplaced, type Piece } from "../piece";

type Stored = Pick<DrawingBody, "points" | "pieces">;

/** Pieces as the server takes them: their points in turn, and how each lies, so that it can be edited again. */
export function storedOf(pieces: readonly Piece[]): Stored {
  const most = shares(pieces.map(({ shape }) => shape.length));
  const strokes = pieces.map((piece, i) => thinned(placed(piece), most[i]));
  return {
    points: strokes.flat().map(([x, y]) => [x, y]),
    pieces: pieces.map(({ placement: { centre, angle, scale }, group }, i) => ({
      points: strokes[i].length,
      centre: [centre[0], centre[1]],
      angle,
      scale,
      group,
    })),
  };
}

/** One stroke, with times or without, of which only the points are kept. */
export function strokeOf(path: readonly Point[]): Stored {
  return { points: thinned(path, POINTS_MAX).map(([x, y]) => [x, y]), pieces: null };
}

/** The pieces of a stored drawing. */
export function piecesOf(points: readonly Point[], stored: NonNullable<DrawingBody["pieces"]>): Piece[] {
  let first = 0;
  return stored.map(({ points: count, centre, angle, scale, group }) => {
    const placement = { centre, angle, scale };
    const shape = points.slice(first, (first += count)).map((point) => unplaced(placement, point));
    return { shape, placement, times: null, group };
  });
}

/** How many points each of some strokes may keep, of as many as a drawing has: at least its two ends. */
function shares(counts: readonly number[]): number[] {
  const all = counts.reduce((sum, count) => sum + count, 0);
  if (all <= POINTS_MAX) return [...counts];
  const share = (POINTS_MAX - 2 * counts.length) / all;
  return counts.map((count) => Math.min(count, 2 + Math.floor(share * count)));
}
