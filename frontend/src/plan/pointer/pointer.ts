import type { Point } from "../../api/types";
import { distance } from "../../drawing/piece";
import type { TargetControl } from "../../operate/target/targetControl";
import { pan, toPixel, zoomAbout, type Size, type View } from "../transform";
import { isCarried, isSameGround, planeAt, targetAt, type Ground, type Hold, type Spot } from "./ground";
import type { Gesture } from "./pens";

/** The plan as the pointer acts on it. */
export interface PlanSurface {
  view: View;
  readonly size: Size;
  /** How near to the target's handle a press must be to take it [px]. */
  handleReach(touch: boolean): number;
  /** A drawing tool is chosen: presses are its own. */
  drawing(): boolean;
  /** What a press on `point` [m] does to the drawing, null for nothing; within `reach` [px] it counts as a hit. With
   * `adds`, what is pressed comes to what is selected. */
  grab(point: Point, reach: number, adds: boolean): Gesture | null;
  fit(): void;
  /** The pointer is over `point` [m], or has left. */
  hover(point: Point | null, overHandle: boolean): void;
}

type Grip =
  | { kind: "target"; id: number; hold: Hold; last: Spot }
  | { kind: "gesture"; id: number; ground: Ground; gesture: Gesture }
  | { kind: "pan" }
  /** The target was pressed and may not be moved, as the plan says: this finger moves nothing else either. */
  | { kind: "refused" }
  /** The plan moved under the press: it is worth nothing until every finger is up. */
  | { kind: "dead" }
  | null;

const MIDDLE_BUTTON = 1;
const HIT_PX = 9;
const FINGER_PX = 22;
const MOVED = "The plan moved under the pointer: held. Let go and press again";

/** `pointermove` comes once a frame; the raw event comes at the device's rate, where the browser offers it. */
const MOVE = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";

/**
 * Mouse, pen and touch on the plan: drag the target, draw, pan, zoom by wheel or pinch, fit by double-click.
 *
 * A press is mapped by the ground on which it began. Once that has changed, the press ends, and the rig holds.
 */
export class PlanPointer {
  private readonly touching = new Map<number, Point>();
  private grip: Grip = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly on: PlanSurface,
    private readonly targetControl: Pick<TargetControl, "handle" | "move" | "release" | "abort">,
  ) {}

  /** Start listening; returns how to stop. */
  listen(): () => void {
    const stop = new AbortController();
    const options = { signal: stop.signal, passive: false };
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (e) => this.down(e), options); // prettier-ignore
    canvas.addEventListener(MOVE, (e) => this.dragTarget(e as PointerEvent), options); // prettier-ignore
    canvas.addEventListener("pointermove", (e) => this.move(e), options); // prettier-ignore
    canvas.addEventListener("pointermove", (e) => this.draw(e), options); // prettier-ignore
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(end, (e) => this.up(e), options); // prettier-ignore
    canvas.addEventListener("pointerleave", () => this.on.hover(null, false), options); // prettier-ignore
    canvas.addEventListener("wheel", (e) => this.wheel(e), options); // prettier-ignore
    canvas.addEventListener("dblclick", () => { if (!this.on.drawing()) this.on.fit(); }, options); // prettier-ignore
    return () => {
      stop.abort();
      this.die();
    };
  }

  /** End a press whose ground has changed; looked at with each of its events and once a frame. */
  check(): void {
    const { grip } = this;
    if (grip?.kind === "target" && !isSameGround(grip.hold.ground, this.ground())) this.die();
    else if (grip?.kind === "gesture" && !isSameGround(grip.ground, this.ground())) this.die();
  }

  /** The press is over before its pointer is up: the rig holds, and what was drawn so far stays. */
  private die(): void {
    const { grip } = this;
    if (grip?.kind !== "target" && grip?.kind !== "gesture") return;
    this.grip = { kind: "dead" };
    if (grip.kind === "target") this.targetControl.abort(MOVED);
    else grip.gesture.end();
  }

  private ground(): Ground {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const { devicePixelRatio, innerWidth, innerHeight, screenX, screenY, visualViewport } = window;
    const { scale = 1, offsetLeft = 0, offsetTop = 0 } = visualViewport ?? {};
    const around = [devicePixelRatio, innerWidth, innerHeight, screenX, screenY];
    return {
      view: this.on.view,
      left,
      top,
      width,
      height,
      around: [...around, scale, offsetLeft, offsetTop],
    };
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 && event.button !== MIDDLE_BUTTON) return;
    if (this.touching.has(event.pointerId)) this.up(event); // that it came up was not told
    this.canvas.setPointerCapture(event.pointerId);
    const alone = this.touching.size === 0 && event.button === 0;
    this.touching.set(event.pointerId, clientOf(event));
    this.check();
    if (this.grip?.kind === "target" || this.grip?.kind === "dead") return;
    const grip = alone ? this.gripOf(event) : null;
    if (this.grip?.kind === "gesture") this.grip.gesture.cancel();
    this.grip = grip ?? { kind: "pan" };
  }

  /** What lies on top is taken first: the target, then the drawing. */
  private gripOf(event: PointerEvent): Grip {
    const ground = this.ground();
    const target = this.on.drawing() ? null : this.targetGrip(event, ground);
    if (target) return target;
    const reach = event.pointerType === "mouse" ? HIT_PX : FINGER_PX;
    const gesture = this.on.grab(planeAt(ground, clientOf(event)), reach, event.shiftKey);
    return gesture && { kind: "gesture", id: event.pointerId, ground, gesture };
  }

  /** Take the handle where it was touched: it does not jump under the pointer. */
  private targetGrip(event: PointerEvent, ground: Ground): Grip {
    const target = this.handle();
    if (!target || !this.isNear(event, ground)) return null;
    if (!this.targetControl.move(target, true, true)) return { kind: "refused" };
    const hold = { ground, pressed: clientOf(event), target };
    return { kind: "target", id: event.pointerId, hold, last: spotOf(event) };
  }

  private dragTarget(event: PointerEvent): void {
    if (!this.holds(event) || this.grip?.kind !== "target") return;
    const spot = spotOf(event);
    if (isCarried(this.grip.last, spot)) {
      this.die();
      return;
    }
    this.grip.last = spot;
    this.targetControl.move(targetAt(this.grip.hold, spot.client), false, true);
  }

  /** Every position since the last frame: a fast stroke stays round. */
  private draw(event: PointerEvent): void {
    if (!this.holds(event) || this.grip?.kind !== "gesture") return;
    const { ground, gesture } = this.grip;
    const events = event.getCoalescedEvents();
    gesture.move((events.length > 0 ? events : [event]).map((one) => planeAt(ground, clientOf(one))));
  }

  /** Whether this pointer's press goes on, on the ground on which it began. */
  private holds(event: PointerEvent): boolean {
    this.check();
    const { grip } = this;
    return (grip?.kind === "target" || grip?.kind === "gesture") && grip.id === event.pointerId;
  }

  private move(event: PointerEvent): void {
    const ground = this.ground();
    const after = clientOf(event);
    this.on.hover(planeAt(ground, after), this.isNear(event, ground));
    const before = this.touching.get(event.pointerId);
    if (!before || this.grip?.kind !== "pan") return;
    this.touching.set(event.pointerId, after);
    const other = [...this.touching].find(([id]) => id !== event.pointerId)?.[1];
    if (other) this.pinch(within(ground, other), within(ground, before), within(ground, after));
    else this.on.view = pan(this.on.view, after[0] - before[0], after[1] - before[1]);
  }

  /** Two fingers: `other` rests, one goes from `before` to `after`. */
  private pinch(other: Point, before: Point, after: Point): void {
    const factor = distance(other, after) / Math.max(1, distance(other, before));
    this.on.view = zoomAbout(this.on.view, this.on.size, other, factor);
  }

  private up(event: PointerEvent): void {
    this.check();
    this.touching.delete(event.pointerId);
    if (this.grip?.kind === "target" && this.grip.id === event.pointerId) {
      this.targetControl.release();
      this.grip = null;
    }
    if (this.grip?.kind === "gesture" && this.grip.id === event.pointerId)
      this.endGesture(event, this.grip.gesture);
    if (this.touching.size === 0) this.grip = null;
  }

  private endGesture(event: PointerEvent, gesture: Gesture): void {
    this.grip = null;
    if (event.type === "pointerup") gesture.end();
    else gesture.cancel();
  }

  /** The picture stands still under a press: what is held would move, or the press end. */
  private wheel(event: WheelEvent): void {
    event.preventDefault();
    if (this.grip?.kind === "target" || this.grip?.kind === "gesture") return;
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const factor = Math.exp(-event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0015));
    this.on.view = zoomAbout(this.on.view, this.on.size, within(this.ground(), clientOf(event)), factor);
  }

  /** Where the target's handle is [m]. */
  private handle(): Point | null {
    return this.targetControl.handle(performance.now())?.point ?? null;
  }

  private isNear(event: PointerEvent, ground: Ground): boolean {
    const target = this.handle();
    if (!target) return false;
    const pixel = within(ground, clientOf(event));
    return (
      distance(toPixel(ground.view, ground, target), pixel) <=
      this.on.handleReach(event.pointerType !== "mouse")
    );
  }
}

function clientOf(event: MouseEvent): Point {
  return [event.clientX, event.clientY];
}

function spotOf(event: MouseEvent): Spot {
  return { client: clientOf(event), screen: [event.screenX, event.screenY] };
}

/** A position in the window from the plan's own corner [px]. */
function within({ left, top }: Ground, [clientX, clientY]: Point): Point {
  return [clientX - left, clientY - top];
}
