import { markersOf } from "../../operate/sensing/residual";
import type { Look, Sheet } from "./canvas";
import { arrowOf, backbone, paintFigure, type Figure } from "./figure";

/** A move of this many device pixels is painted at once. */
const SEEN_PX = 0.5;
/** Less than this cannot be told from standing still [device px]. */
const STILL_PX = 0.1;
/** What lies between, as sensor noise moves a figure at rest, is painted this often [s]. */
const TREMBLE_S = 0.2;
/** Trail nearer to the tip than this lies under the tip's disc [px]. */
const COVERED_PX = 2;
const NOWHERE = [NaN, NaN] as const;

/** The moving figure on its canvas: painted when it would look different. */
export class FigureLayer {
  private look: Look | null = null;
  private outline: readonly number[] = [];
  private paintedAt = -Infinity;

  /** Paint on the sheet that `open` gives, if the figure or how it is looked at has changed. */
  paint(look: Look, figure: Figure, open: () => Sheet | null): void {
    const outline = outlineOf(figure, look);
    if (look === this.look && !this.isDue(outline, figure.now)) return;
    const sheet = open();
    if (!sheet) return;
    sheet.g.clearRect(0, 0, look.size.width, look.size.height);
    paintFigure(sheet, figure, look.hidden);
    this.look = look;
    this.outline = outline;
    this.paintedAt = figure.now;
  }

  private isDue(outline: readonly number[], now: number): boolean {
    const move = largestMove(this.outline, outline);
    return move >= SEEN_PX || (move >= STILL_PX && now - this.paintedAt >= TREMBLE_S);
  }
}

/** Everything of the figure that can change: lengths in device pixels, states and counts as whole numbers. */
function outlineOf(figure: Figure, { view, ratio }: Look): number[] {
  const { telemetry, handle } = figure;
  const markers = markersOf(telemetry);
  const points = [
    ...backbone(telemetry, "backbone"),
    ...backbone(telemetry, "twin_backbone"),
    ...markers.map(({ measured }) => measured),
    ...markers.map((marker) => arrowOf(marker, view.scale) ?? NOWHERE),
    telemetry.point("p_ref") ?? NOWHERE,
    handle?.point ?? NOWHERE,
  ];
  const states = [handle?.movable, handle?.acknowledged].map(Number);
  const numbers = [telemetry.at("reachable"), telemetry.at("sensed"), ...markers.map(({ rod }) => rod)];
  const pixels = [...points.flat(), figure.width].map((metres) => metres * view.scale * ratio);
  return [...pixels, ...states, ...numbers, hasTrail(figure, view.scale) ? figure.frames : 0];
}

/** Whether any trail can be seen: one that can fades from frame to frame. */
function hasTrail({ trail, now }: Figure, scale: number): boolean {
  const points: [number, number][] = [];
  trail.visit(now, (x, y) => points.push([x, y]));
  const [x, y] = points.at(-1) ?? NOWHERE;
  return points.some((point) => Math.hypot(point[0] - x, point[1] - y) * scale > COVERED_PX);
}

/** How far anything went from one outline to another; without end where something came or went. */
function largestMove(before: readonly number[], after: readonly number[]): number {
  if (before.length !== after.length) return Infinity;
  return after.reduce((largest, value, i) => Math.max(largest, moveOf(before[i], value)), 0);
}

function moveOf(before: number, after: number): number {
  if (Number.isNaN(before) && Number.isNaN(after)) return 0;
  const move = Math.abs(after - before);
  return Number.isNaN(move) ? Infinity : move;
}
