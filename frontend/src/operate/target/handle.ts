import type { Mode, Point } from "../../api/types";
import { isMovable, MODE } from "../../live/modes";

/** Where the target handle stands, whether the rig has it already, and whether it may be moved in this state. */
export interface Handle {
  readonly point: Point;
  readonly acknowledged: boolean;
  readonly movable: boolean;
}

/** What the operator last asked for by pointer or arrow key. */
export interface Wish {
  readonly point: Point;
  /** Page clock [ms]. */
  readonly at: number;
  /** The pointer still holds it. */
  readonly held: boolean;
}

/** The rig's side, from telemetry. */
export interface RigTarget {
  readonly mode: Mode | null;
  readonly target: Point | null;
  readonly reference: Point | null;
  readonly tip: Point | null;
}

const SAME_M = 1e-6;
/** A wish let go that the rig does not echo within this time was not taken. */
const WISH_SHOWN_MS = 500;

/** The operator's wish, hollow until the rig echoes it; without a wish, where the rig's own target stands. */
export function handleOf(wish: Wish | null, rig: RigTarget, now: number): Handle | null {
  if (rig.mode === null) return null;
  if (!isMovable(rig.mode)) return rig.tip && { point: rig.tip, acknowledged: false, movable: false };
  const following = rig.mode === MODE.FOLLOW;
  if (wish && (wish.held || now - wish.at < WISH_SHOWN_MS)) {
    const acknowledged = following && rig.target !== null && samePoint(rig.target, wish.point);
    return { point: wish.point, acknowledged, movable: true };
  }
  const point = following ? rig.target : rig.reference;
  return point && { point, acknowledged: following, movable: true };
}

export function samePoint(a: Point, b: Point): boolean {
  return Math.hypot(a[0] - b[0], a[1] - b[1]) < SAME_M;
}
