import type { Point } from "../../api/types";
import { frameOf, type Frame, type Outline } from "../../drawing/piece";
import { ROLE } from "../../ui/colours";
import { disc, segment, type Sheet } from "./canvas";

const MARGIN_PX = 10;
const ARM_PX = 24;
const HANDLE_PX = 5;

/** The box with handles around what is selected, at `scale` pixels per metre. */
export function frameAt(outline: Outline, scale: number): Frame {
  return frameOf(outline, MARGIN_PX / scale, ARM_PX / scale);
}

/** Squares scale, the disc above turns, the cross in the middle moves. */
export function paintHandles(sheet: Sheet, outline: Outline): void {
  const { g, ink, view, pixel } = sheet;
  const { corners, turn, centre } = frameAt(outline, view.scale);
  const [lowerLeft, lowerRight, upperRight, upperLeft] = corners.map(pixel);
  g.save();
  g.strokeStyle = ink.soft;
  g.lineWidth = 1;
  for (const [from, to] of [
    [lowerLeft, lowerRight],
    [lowerRight, upperRight],
    [upperRight, upperLeft],
    [upperLeft, lowerLeft],
    [middle(upperLeft, upperRight), pixel(turn)],
  ])
    segment(g, from, to);
  g.fillStyle = ink.paper;
  g.strokeStyle = ROLE.reference;
  g.lineWidth = 1.5;
  for (const corner of corners) paintSquare(g, pixel(corner));
  disc(g, pixel(turn), HANDLE_PX);
  g.fill();
  g.stroke();
  paintCross(g, pixel(centre));
  g.restore();
}

function paintSquare(g: CanvasRenderingContext2D, [px, py]: Point): void {
  g.beginPath();
  g.rect(px - HANDLE_PX, py - HANDLE_PX, 2 * HANDLE_PX, 2 * HANDLE_PX);
  g.fill();
  g.stroke();
}

function paintCross(g: CanvasRenderingContext2D, [px, py]: Point): void {
  segment(g, [px - HANDLE_PX, py], [px + HANDLE_PX, py]);
  segment(g, [px, py - HANDLE_PX], [px, py + HANDLE_PX]);
}

function middle(a: Point, b: Point): Point {
  return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
}
