import type { Point } from "../../api/types";
import { thinned } from "../piece";

/** More points than this are not told apart in a small picture. */
const POINTS_MAX = 200;

/** An SVG path of the points as large as fits in the middle of a box [px], y up, equal scales; "" for no points. */
export function thumbnailPath(points: readonly Point[], width: number, height: number): string {
  const few = thinned(points, POINTS_MAX);
  const [left, right] = extremes(few.map(([x]) => x));
  const [bottom, top] = extremes(few.map(([, y]) => y));
  const scale = Math.min(width / Math.max(right - left, 1e-9), height / Math.max(top - bottom, 1e-9));
  const places = few.map(([x, y]) => [
    width / 2 + (x - (left + right) / 2) * scale,
    height / 2 - (y - (bottom + top) / 2) * scale,
  ]);
  return places
    .map((place, i) => `${i === 0 ? "M" : "L"}${place.map((px) => px.toFixed(1)).join(" ")}`)
    .join("");
}

function extremes(values: readonly number[]): [number, number] {
  return [Math.min(...values), Math.max(...values)];
}
