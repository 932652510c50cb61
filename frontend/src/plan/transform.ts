import type { Point } from "../api/types";

/** View of the plane: `centre` [m] stands in the middle of the canvas, `scale` is in CSS pixels per metre, y goes up. */
export interface View {
  readonly centre: Point;
  readonly scale: number;
}

/** Size of the canvas in CSS pixels. */
export interface Size {
  readonly width: number;
  readonly height: number;
}

/** Box in the plane [m]. */
export interface Box {
  readonly left: number;
  readonly right: number;
  readonly bottom: number;
  readonly top: number;
}

const SCALE_MIN = 100;
const SCALE_MAX = 100_000;

export function toPixel(view: View, size: Size, [x, y]: Point): Point {
  return [
    size.width / 2 + (x - view.centre[0]) * view.scale,
    size.height / 2 - (y - view.centre[1]) * view.scale,
  ];
}

export function toPlane(view: View, size: Size, [px, py]: Point): Point {
  return [
    view.centre[0] + (px - size.width / 2) / view.scale,
    view.centre[1] - (py - size.height / 2) / view.scale,
  ];
}

/** Zoom by `factor`; the point of the plane under `pixel` stays there. */
export function zoomAbout(view: View, size: Size, pixel: Point, factor: number): View {
  const scale = Math.min(SCALE_MAX, Math.max(SCALE_MIN, view.scale * factor));
  const [x, y] = toPlane(view, size, pixel);
  const ratio = view.scale / scale;
  return { scale, centre: [x + (view.centre[0] - x) * ratio, y + (view.centre[1] - y) * ratio] };
}

/** Move the picture by (dx, dy) pixels. */
export function pan(view: View, dx: number, dy: number): View {
  return { ...view, centre: [view.centre[0] - dx / view.scale, view.centre[1] + dy / view.scale] };
}

/** The view that shows `box` as large as it goes, with `margin` pixels around it. */
export function fit(box: Box, size: Size, margin: number): View {
  const [width, height] = [size.width - 2 * margin, size.height - 2 * margin];
  const scale = Math.min(width / (box.right - box.left), height / (box.top - box.bottom));
  return {
    scale: Math.min(SCALE_MAX, Math.max(SCALE_MIN, scale)),
    centre: [(box.left + box.right) / 2, (box.bottom + box.top) / 2],
  };
}

/** The smallest box around `points`, null without any. */
export function boundingBox(points: readonly (Point | null)[]): Box | null {
  let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const point of points)
    if (point) {
      left = Math.min(left, point[0]);
      right = Math.max(right, point[0]);
      bottom = Math.min(bottom, point[1]);
      top = Math.max(top, point[1]);
    }
  return right > left && top > bottom ? { left, right, bottom, top } : null;
}
