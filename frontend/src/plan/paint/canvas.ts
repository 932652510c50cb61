import type { Point } from "../../api/types";
import type { Ink, Scheme } from "../../ui/colours";
import type { Hidden } from "../layers";
import { toPixel, type Size, type View } from "../transform";

/** How the plan is looked at: another object once any of it changes, so that layers know what they painted. */
export interface Look {
  readonly view: View;
  readonly size: Size;
  readonly scheme: Scheme;
  /** Device pixels per CSS pixel. */
  readonly ratio: number;
  readonly hidden: Hidden;
}

/** Where painters draw: CSS pixels, with the plane's transform at hand. */
export interface Sheet {
  readonly g: CanvasRenderingContext2D;
  readonly view: View;
  readonly size: Size;
  readonly ink: Ink;
  readonly pixel: (point: Point) => Point;
}

export function sheetOf(g: CanvasRenderingContext2D, view: View, size: Size, ink: Ink): Sheet {
  return { g, view, size, ink, pixel: (point) => toPixel(view, size, point) };
}

/** Give `canvas` the size in CSS pixels at the screen's own resolution; drawing then uses CSS pixels. */
export function resize(
  canvas: HTMLCanvasElement,
  size: Size,
  ratio: number,
): CanvasRenderingContext2D | null {
  const [width, height] = [Math.round(size.width * ratio), Math.round(size.height * ratio)];
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  const g = canvas.getContext("2d");
  g?.setTransform(ratio, 0, 0, ratio, 0, 0);
  return g;
}

export function polyline(sheet: Sheet, points: readonly Point[]): void {
  const { g } = sheet;
  g.beginPath();
  for (const point of points) {
    const [px, py] = sheet.pixel(point);
    g.lineTo(px, py);
  }
}

export function disc(g: CanvasRenderingContext2D, [px, py]: Point, radius: number): void {
  g.beginPath();
  g.arc(px, py, radius, 0, 2 * Math.PI);
}

export function segment(g: CanvasRenderingContext2D, from: Point, to: Point): void {
  g.beginPath();
  g.moveTo(from[0], from[1]);
  g.lineTo(to[0], to[1]);
  g.stroke();
}
