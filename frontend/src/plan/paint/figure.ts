import type { Point } from "../../api/types";
import { distance } from "../../drawing/piece";
import type { Trail } from "../../live/trail";
import type { Handle } from "../../operate/target/handle";
import type { Telemetry } from "../../live/telemetry";
import { arrowEnd, markersOf, type Marker } from "../../operate/sensing/residual";
import { ROLE } from "../../ui/colours";
import type { Hidden } from "../layers";
import { disc, polyline, segment, type Sheet } from "./canvas";

/** Residual arrows are drawn this many times as long as they are. */
export const RESIDUAL_GAIN = 5;
const ARROW_PX = 3;
const TRAIL_SHADES = 12;
const HANDLE_M = 0.006;
const HANDLE_PX = 7;

/** Everything of the moving figure that is not telemetry. */
export interface Figure {
  readonly telemetry: Telemetry;
  readonly trail: Trail;
  readonly handle: Handle | null;
  /** Drawn width of the actuator [m]. */
  readonly width: number;
  /** Page clock [s]. */
  readonly now: number;
  /** Telemetry frames received so far. */
  readonly frames: number;
}

/** The moving figure: body, backbones, markers, trail, reference and target. */
export function paintFigure(sheet: Sheet, figure: Figure, hidden: Hidden): void {
  const { telemetry } = figure;
  const observer = !hidden.has("observer");
  if (observer) paintBody(sheet, backbone(telemetry, "backbone"), figure.width);
  if (!hidden.has("twin")) paintTwin(sheet, backbone(telemetry, "twin_backbone"));
  if (!hidden.has("measured")) paintTrail(sheet, figure.trail, figure.now);
  if (observer) paintObserver(sheet, backbone(telemetry, "backbone"));
  if (!hidden.has("measured")) for (const marker of markersOf(telemetry)) paintMarker(sheet, marker);
  paintTarget(sheet, figure);
}

/** The points of a backbone that are known [m]. */
export function backbone(telemetry: Telemetry, name: "backbone" | "twin_backbone"): Point[] {
  const points: Point[] = [];
  for (let i = 0; i < telemetry.points(name); i++) {
    const point = telemetry.point(name, i);
    if (point) points.push(point);
  }
  return points;
}

function paintBody(sheet: Sheet, points: readonly Point[], width: number): void {
  const { g, view } = sheet;
  g.save();
  g.globalAlpha = 0.14;
  g.strokeStyle = ROLE.observer;
  g.lineWidth = width * view.scale;
  g.lineJoin = "round";
  polyline(sheet, points);
  g.stroke();
  g.restore();
}

function paintTwin(sheet: Sheet, points: readonly Point[]): void {
  const { g } = sheet;
  g.strokeStyle = ROLE.twin;
  g.lineWidth = 1.5;
  polyline(sheet, points);
  g.stroke();
}

function paintObserver(sheet: Sheet, points: readonly Point[]): void {
  const { g } = sheet;
  g.strokeStyle = g.fillStyle = ROLE.observer;
  g.lineWidth = 2.5;
  g.lineJoin = "round";
  polyline(sheet, points);
  g.stroke();
  const tip = points.at(-1);
  if (!tip) return;
  disc(g, sheet.pixel(tip), 3);
  g.fill();
}

/** In a few shades, a stroke each: a stroke per point would cost more than all the rest of the figure. */
function paintTrail(sheet: Sheet, trail: Trail, now: number): void {
  const { g } = sheet;
  let [last, shade]: [Point | null, number] = [null, 0];
  g.strokeStyle = ROLE.measured;
  g.lineWidth = 2;
  g.lineJoin = "round";
  g.beginPath();
  trail.visit(now, (x, y, freshness) => {
    const next = sheet.pixel([x, y]);
    const wanted = Math.ceil(freshness * TRAIL_SHADES);
    if (last && wanted !== shade) {
      g.stroke();
      g.beginPath();
      g.moveTo(last[0], last[1]);
    }
    shade = wanted;
    g.globalAlpha = (0.7 * shade) / TRAIL_SHADES;
    g.lineTo(next[0], next[1]);
    last = next;
  });
  g.stroke();
  g.globalAlpha = 1;
}

/** End of a marker's residual arrow [m], null where none is drawn; `scale` in pixels per metre. */
export function arrowOf({ measured, observed, sensed }: Marker, scale: number): Point | null {
  if (!sensed || !observed) return null;
  const end = arrowEnd(observed, measured, RESIDUAL_GAIN);
  return distance(observed, end) * scale < ARROW_PX ? null : end;
}

function paintMarker(sheet: Sheet, marker: Marker): void {
  const { g, ink } = sheet;
  const { measured, observed, sensed } = marker;
  g.strokeStyle = ROLE.measured;
  g.fillStyle = sensed ? ROLE.measured : ink.paper;
  g.lineWidth = 1.5;
  disc(g, sheet.pixel(measured), sensed ? 4.5 : 3.5);
  g.fill();
  g.stroke();
  const end = arrowOf(marker, sheet.view.scale);
  if (observed && end) paintArrow(sheet, observed, end);
}

function paintArrow(sheet: Sheet, from: Point, to: Point): void {
  const { g } = sheet;
  const [start, end] = [sheet.pixel(from), sheet.pixel(to)];
  const [dx, dy] = [end[0] - start[0], end[1] - start[1]];
  const length = Math.hypot(dx, dy);
  const [ux, uy] = [(4 * dx) / length, (4 * dy) / length];
  g.strokeStyle = ROLE.measured;
  g.lineWidth = 1.5;
  segment(g, start, end);
  segment(g, end, [end[0] - ux - uy, end[1] - uy + ux]);
  segment(g, end, [end[0] - ux + uy, end[1] - uy - ux]);
}

function paintTarget(sheet: Sheet, { telemetry, handle }: Figure): void {
  if (!handle) return;
  const reference = telemetry.point("p_ref");
  const centre = sheet.pixel(handle.point);
  if (reference && handle.movable && telemetry.at("reachable") === 0)
    paintClamp(sheet, centre, sheet.pixel(reference));
  paintHandle(sheet, handle, centre, handle.acknowledged && telemetry.at("reachable") === 1);
  if (reference && handle.movable) paintReference(sheet, sheet.pixel(reference));
}

/** Radius of the target's 12 mm handle [px]. */
export function handleRadius(scale: number): number {
  return Math.max(HANDLE_PX, HANDLE_M * scale);
}

/** Hollow until the rig has echoed it and while it is out of reach, dashed while it cannot be moved. */
function paintHandle({ g, ink, view }: Sheet, { movable }: Handle, centre: Point, filled: boolean): void {
  const radius = handleRadius(view.scale);
  g.strokeStyle = g.fillStyle = movable ? ink.target : ink.soft;
  g.lineWidth = 2;
  g.setLineDash(movable ? [] : [3, 3]);
  disc(g, centre, radius);
  g.stroke();
  g.setLineDash([]);
  if (!filled) return;
  disc(g, centre, radius - 3);
  g.fill();
}

/** From the wish to the nearest point that can be reached. */
function paintClamp({ g }: Sheet, wish: Point, clamped: Point): void {
  g.strokeStyle = ROLE.danger;
  g.lineWidth = 1.5;
  g.setLineDash([2, 3]);
  segment(g, wish, clamped);
  g.setLineDash([]);
}

function paintReference({ g }: Sheet, [px, py]: Point): void {
  g.strokeStyle = ROLE.reference;
  g.lineWidth = 2;
  const arm = 9;
  segment(g, [px - arm, py], [px - 3, py]);
  segment(g, [px + 3, py], [px + arm, py]);
  segment(g, [px, py - arm], [px, py - 3]);
  segment(g, [px, py + 3], [px, py + arm]);
}
