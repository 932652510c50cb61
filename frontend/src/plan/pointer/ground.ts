import type { Point } from "../../api/types";
import { distance } from "../../drawing/piece";
import { toPlane, type View } from "../transform";

/** What a press on the plan is mapped by, as it stood when it began: where the plan lies, and how it looks at the plane. */
export interface Ground {
  readonly view: View;
  /** Place and size of the plan in the window [CSS px]. */
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
  /** What else moves the plan under a resting pointer: window, browser zoom, a page that is pinched larger. */
  readonly around: readonly number[];
}

/** One position of a pointer, in the window and on the screen. */
export interface Spot {
  readonly client: Point;
  readonly screen: Point;
}

/** A target that a pointer holds: what was pressed where, and what the press is mapped by. */
export interface Hold {
  readonly ground: Ground;
  readonly pressed: Point;
  readonly target: Point;
}

/** A plan that is laid out again may differ by less than this [px]. */
const SAME_PX = 0.5;
/** A window may have four CSS pixels for one of the screen (25 % zoom), and positions are rounded. */
const LEAST_ZOOM = 4;
const ROUNDING_PX = 2;

export function isSameGround(a: Ground, b: Ground): boolean {
  const near = (name: "left" | "top" | "width" | "height") => Math.abs(a[name] - b[name]) < SAME_PX;
  return (
    a.view.scale === b.view.scale &&
    a.view.centre[0] === b.view.centre[0] &&
    a.view.centre[1] === b.view.centre[1] &&
    near("left") &&
    near("top") &&
    near("width") &&
    near("height") &&
    a.around.length === b.around.length &&
    a.around.every((value, i) => value === b.around[i])
  );
}

/** Point of the plane [m] under a position in the window. */
export function planeAt({ view, left, top, width, height }: Ground, [clientX, clientY]: Point): Point {
  return toPlane(view, { width, height }, [clientX - left, clientY - top]);
}

/** Where a held target is wanted: as far from where it was pressed as its pointer went, at the scale of the press. */
export function targetAt({ ground, pressed, target }: Hold, client: Point): Point {
  const { scale } = ground.view;
  return [target[0] + (client[0] - pressed[0]) / scale, target[1] - (client[1] - pressed[1]) / scale];
}

/** Whether the window went along under a pointer that hardly moved on the screen: its position says nothing then. */
export function isCarried(before: Spot, now: Spot): boolean {
  return distance(before.client, now.client) > LEAST_ZOOM * distance(before.screen, now.screen) + ROUNDING_PX;
}
