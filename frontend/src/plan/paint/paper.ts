import type { Point } from "../../api/types";
import { FONT } from "../../ui/colours";
import { toPlane } from "../transform";
import { resize, segment, type Sheet } from "./canvas";
import { hull, type Quad } from "./reach";
import { niceStep } from "../../plots/chart/axes";

/** What lies under the moving parts: grid, reach, base and scale bar. Painted only when the view changes. */
export function paintPaper(sheet: Sheet, reach: Reach | null, ratio: number): void {
  const { g, size, ink } = sheet;
  g.fillStyle = ink.paper;
  g.fillRect(0, 0, size.width, size.height);
  if (reach) {
    paintHole(sheet, reach, ratio);
    paintReach(sheet, reach.covered, ratio);
  }
  const grid = gridFor(sheet.view.scale);
  paintLines(sheet, grid.minor, ink.grid);
  paintLines(sheet, grid.major, ink.gridMajor);
  paintLabels(sheet, grid.major);
  paintBase(sheet);
  paintScaleBar(sheet, grid.bar);
}

/** The reach as paths in metres: made once, painted under any view. */
export interface Reach {
  readonly covered: Path2D;
  /** Its convex hull. */
  readonly hull: Path2D;
}

export function reachOf(quads: readonly Quad[], points: readonly Point[]): Reach {
  return { covered: quadPath(quads), hull: ringPath(hull(points)) };
}

function ringPath(points: readonly Point[]): Path2D {
  const path = new Path2D();
  for (const [x, y] of points) path.lineTo(x, y);
  path.closePath();
  return path;
}

function quadPath(quads: readonly Quad[]): Path2D {
  const path = new Path2D();
  for (const [a, b, c, d] of quads) {
    path.moveTo(a[0], a[1]);
    path.lineTo(b[0], b[1]);
    path.lineTo(c[0], c[1]);
    path.lineTo(d[0], d[1]);
    path.closePath();
  }
  return path;
}

/** What the reach leaves out inside its own hull, hatched. */
function paintHole(sheet: Sheet, reach: Reach, ratio: number): void {
  const { size, ink } = sheet;
  const layer = document.createElement("canvas");
  const context = resize(layer, size, ratio);
  if (!context) return;
  const pixels = context.getTransform();
  toMetres(context, sheet);
  context.clip(reach.hull);
  context.setTransform(pixels);
  context.strokeStyle = ink.soft;
  for (let x = -size.height; x < size.width; x += 9) segment(context, [x, size.height], [x + size.height, 0]);
  toMetres(context, sheet);
  context.globalCompositeOperation = "destination-out";
  context.lineWidth = 1 / sheet.view.scale;
  context.fill(reach.covered);
  context.stroke(reach.covered);
  layDown(sheet, layer, 0.35);
}

function toMetres(context: CanvasRenderingContext2D, { view, pixel }: Sheet): void {
  const [x, y] = pixel([0, 0]);
  context.transform(view.scale, 0, 0, -view.scale, x, y);
}

function layDown({ g, size }: Sheet, layer: HTMLCanvasElement, alpha: number): void {
  g.globalAlpha = alpha;
  g.drawImage(layer, 0, 0, size.width, size.height);
  g.globalAlpha = 1;
}

/** Painted opaque (with strokes that hide the seams) on a layer of its own, then laid down at one opacity. */
function paintReach(sheet: Sheet, covered: Path2D, ratio: number): void {
  const layer = document.createElement("canvas");
  const context = resize(layer, sheet.size, ratio);
  if (!context) return;
  const [colour, alpha] = opaque(sheet.ink.reach);
  toMetres(context, sheet);
  context.fillStyle = context.strokeStyle = colour;
  context.lineWidth = 1 / sheet.view.scale;
  context.fill(covered);
  context.stroke(covered);
  layDown(sheet, layer, alpha);
}

/** "rgba(r, g, b, a)" as an opaque colour and its alpha. */
function opaque(colour: string): [string, number] {
  const [r, g, b, alpha] = colour.replace(/[^\d.,]/g, "").split(",");
  return [`rgb(${r}, ${g}, ${b})`, Number(alpha)];
}

function edges({ view, size }: Sheet): { left: number; right: number; bottom: number; top: number } {
  const [left, top] = toPlane(view, size, [0, 0]);
  const [right, bottom] = toPlane(view, size, [size.width, size.height]);
  return { left, right, bottom, top };
}

function paintLines(sheet: Sheet, step: number, colour: string): void {
  const { g, size } = sheet;
  const { left, right, bottom, top } = edges(sheet);
  g.strokeStyle = colour;
  g.lineWidth = 1;
  for (const x of ticks(left, right, step)) {
    const px = Math.round(sheet.pixel([x, 0])[0]) + 0.5;
    segment(g, [px, 0], [px, size.height]);
  }
  for (const y of ticks(bottom, top, step)) {
    const py = Math.round(sheet.pixel([0, y])[1]) + 0.5;
    segment(g, [0, py], [size.width, py]);
  }
}

function paintLabels(sheet: Sheet, step: number): void {
  const { g, size, ink } = sheet;
  const { left, right, bottom, top } = edges(sheet);
  g.fillStyle = ink.soft;
  g.font = `11px ${FONT}`;
  g.textAlign = "center";
  for (const x of ticks(left, right, step)) {
    const px = sheet.pixel([x, 0])[0];
    if (px > 30 && px < size.width - 130) g.fillText(String(Math.round(x * 1e4) / 10), px, size.height - 5);
  }
  g.textAlign = "left";
  for (const y of ticks(bottom, top, step)) {
    const py = sheet.pixel([0, y])[1];
    if (py > 8 && py < size.height - 20) g.fillText(String(Math.round(y * 1e4) / 10), 4, py + 4);
  }
}

/** The clamp at the origin: a wall with hatching to its left. */
function paintBase(sheet: Sheet): void {
  const { g, ink } = sheet;
  const [px, py] = sheet.pixel([0, 0]);
  const half = Math.max(10, 0.022 * sheet.view.scale);
  g.strokeStyle = ink.soft;
  g.lineWidth = 2;
  segment(g, [px, py - half], [px, py + half]);
  g.lineWidth = 1;
  for (let y = py - half; y <= py + half - 5; y += 6) segment(g, [px, y], [px - 6, y + 6]);
}

function paintScaleBar({ g, view, size, ink }: Sheet, length: number): void {
  const [right, y] = [size.width - 14, size.height - 12];
  const left = right - length * view.scale;
  g.strokeStyle = g.fillStyle = ink.text;
  g.lineWidth = 2;
  segment(g, [left, y], [right, y]);
  segment(g, [left, y - 4], [left, y + 4]);
  segment(g, [right, y - 4], [right, y + 4]);
  g.textAlign = "center";
  g.fillText(lengthLabel(length), (left + right) / 2, y - 7);
}

/** Distances of grid lines and length of the scale bar [m] that read well at `scale` pixels per metre. */
interface Grid {
  readonly minor: number;
  readonly major: number;
  readonly bar: number;
}

const MINOR_PX = 9;
const MAJOR_PX = 60;
const BAR_PX = 70;

export function gridFor(scale: number): Grid {
  const major = niceStep(MAJOR_PX / scale);
  return { minor: Math.max(niceStep(MINOR_PX / scale), major / 10), major, bar: niceStep(BAR_PX / scale) };
}

/** Multiples of `step` in [from, to]. */
export function ticks(from: number, to: number, step: number): number[] {
  const first = Math.ceil(from / step);
  return Array.from({ length: Math.max(0, Math.floor(to / step) - first + 1) }, (_, i) => (first + i) * step);
}

/** A length as a label: 50 mm, 0.5 mm. */
export function lengthLabel(metres: number): string {
  return `${Number((metres * 1e3).toPrecision(3))} mm`;
}
