import type { Point } from "../api/types";
import type { Gesture } from "./pens";
import { pan, toPlane, zoomAbout, type Size, type View } from "./transform";

/** What the pointer acts on. */
export interface PointerTarget {
  view: View;
  readonly size: Size;
  /** Where the target handle is [px], and how near a press must be to take it. */
  handlePixel(): Point | null;
  handleReach(touch: boolean): number;
  /** The target is wanted at `point` [m]; false: it may not move now. */
  moveTarget(point: Point, fresh: boolean): boolean;
  releaseTarget(): void;
  /** A drawing tool is chosen: presses are its own. */
  drawing(): boolean;
  /** What a press on `point` [m] does to the drawing, null for nothing; within `reach` [px] it counts as a hit. */
  grab(point: Point, reach: number): Gesture | null;
  fit(): void;
  /** The pointer is over `point` [m], or has left. */
  hover(point: Point | null, overHandle: boolean): void;
}

type Grip =
  | { kind: "target"; id: number; offset: Point }
  | { kind: "gesture"; id: number; gesture: Gesture }
  | { kind: "pan" }
  | null;

const MIDDLE_BUTTON = 1;
const HIT_PX = 9;
const FINGER_PX = 22;

/** `pointermove` comes once a frame; the raw event comes at the device's rate, where the browser offers it. */
const MOVE = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";

/** Mouse, pen and touch on the plan: drag the target, draw, pan, zoom by wheel or pinch, fit by double-click. */
export class PlanPointer {
  private readonly touching = new Map<number, Point>();
  private grip: Grip = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly on: PointerTarget,
  ) {}

  /** Start listening; returns how to stop. */
  listen(): () => void {
    const stop = new AbortController();
    const options = { signal: stop.signal, passive: false };
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (e) => { this.down(e); }, options); // prettier-ignore
    canvas.addEventListener(MOVE, (e) => { this.dragTarget(e as PointerEvent); }, options); // prettier-ignore
    canvas.addEventListener("pointermove", (e) => { this.move(e); }, options); // prettier-ignore
    canvas.addEventListener("pointermove", (e) => { this.draw(e); }, options); // prettier-ignore
    for (const end of ["pointerup", "pointercancel"] as const)
      canvas.addEventListener(end, (e) => { this.up(e); }, options); // prettier-ignore
    canvas.addEventListener("pointerleave", () => { this.on.hover(null, false); }, options); // prettier-ignore
    canvas.addEventListener("wheel", (e) => { this.wheel(e); }, options); // prettier-ignore
    canvas.addEventListener("dblclick", () => { if (!this.on.drawing()) this.on.fit(); }, options); // prettier-ignore
    return () => {
      stop.abort();
    };
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 && event.button !== MIDDLE_BUTTON) return;
    this.canvas.setPointerCapture(event.pointerId);
    const pixel = pixelOf(event);
    this.touching.set(event.pointerId, pixel);
    const alone = this.touching.size === 1 && event.button === 0;
    const grip = alone ? this.gripOf(event, pixel) : null;
    if (this.grip?.kind === "target") return;
    if (this.grip?.kind === "gesture") this.grip.gesture.cancel();
    this.grip = grip ?? { kind: "pan" };
  }

  /** What lies on top is taken first: the target, then the drawing. */
  private gripOf(event: PointerEvent, pixel: Point): Grip {
    const target = this.on.drawing() ? null : this.targetGrip(event, pixel);
    if (target) return target;
    const gesture = this.on.grab(this.plane(pixel), event.pointerType === "mouse" ? HIT_PX : FINGER_PX);
    return gesture && { kind: "gesture", id: event.pointerId, gesture };
  }

  /** Take the handle where it was touched: it does not jump under the pointer. */
  private targetGrip(event: PointerEvent, pixel: Point): Grip {
    const handle = this.on.handlePixel();
    if (!handle || !this.isNear(event, pixel)) return null;
    const offset: Point = [handle[0] - pixel[0], handle[1] - pixel[1]];
    if (!this.on.moveTarget(this.plane(handle), true)) return null;
    return { kind: "target", id: event.pointerId, offset };
  }

  private dragTarget(event: PointerEvent): void {
    if (this.grip?.kind !== "target" || this.grip.id !== event.pointerId) return;
    const [px, py] = pixelOf(event);
    this.on.moveTarget(this.plane([px + this.grip.offset[0], py + this.grip.offset[1]]), false);
  }

  /** Every position since the last frame: a fast stroke stays round. */
  private draw(event: PointerEvent): void {
    if (this.grip?.kind !== "gesture" || this.grip.id !== event.pointerId) return;
    const bounds = this.canvas.getBoundingClientRect();
    const events = event.getCoalescedEvents();
    const points = (events.length > 0 ? events : [event]).map(({ clientX, clientY }) =>
      this.plane([clientX - bounds.left, clientY - bounds.top]),
    );
    this.grip.gesture.move(points);
  }

  private move(event: PointerEvent): void {
    const pixel = pixelOf(event);
    this.on.hover(this.plane(pixel), this.isNear(event, pixel));
    const before = this.touching.get(event.pointerId);
    if (!before || this.grip?.kind !== "pan") return;
    this.touching.set(event.pointerId, pixel);
    const other = [...this.touching].find(([id]) => id !== event.pointerId)?.[1];
    if (other) this.pinch(other, before, pixel);
    else this.on.view = pan(this.on.view, pixel[0] - before[0], pixel[1] - before[1]);
  }

  /** Two fingers: `other` rests, one goes from `before` to `after`. */
  private pinch(other: Point, before: Point, after: Point): void {
    const factor = distance(other, after) / Math.max(1, distance(other, before));
    this.on.view = zoomAbout(this.on.view, this.on.size, other, factor);
  }

  private up(event: PointerEvent): void {
    this.touching.delete(event.pointerId);
    if (this.grip?.kind === "target" && this.grip.id === event.pointerId) {
      this.on.releaseTarget();
      this.grip = null;
    }
    if (this.grip?.kind === "gesture" && this.grip.id === event.pointerId)
      this.endGesture(event, this.grip.gesture);
    if (this.touching.size === 0) this.grip = null;
  }

  private endGesture(event: PointerEvent, gesture: Gesture): void {
    this.grip = null;
    if (event.type === "pointercancel") gesture.cancel();
    else gesture.end();
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const factor = Math.exp(-event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0015));
    this.on.view = zoomAbout(this.on.view, this.on.size, pixelOf(event), factor);
  }

  private isNear(event: PointerEvent, pixel: Point): boolean {
    const handle = this.on.handlePixel();
    return handle !== null && distance(handle, pixel) <= this.on.handleReach(event.pointerType !== "mouse");
  }

  private plane(pixel: Point): Point {
    return toPlane(this.on.view, this.on.size, pixel);
  }
}

function pixelOf(event: MouseEvent): Point {
  return [event.offsetX, event.offsetY];
}

function distance(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}
