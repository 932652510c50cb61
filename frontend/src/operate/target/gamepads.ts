import type { Live } from "../../live/live";
import type { Page } from "../../live/page";
import type { Store } from "../../ui/store";
import type { Ticker } from "../../ui/ticker";
import type { Operations } from "../operations";
import type { TargetControl } from "./targetControl";
import type { Point } from "../../api/types";

const RATE = 60;
/** Speed of the full stick, where the rig's own limit is not lower [m/s]. */
const FULL_STICK = 0.1;

/** The parts of the dashboard that a gamepad moves or asks. */
export interface PadParts {
  readonly targetControl: TargetControl;
  readonly live: Live;
  readonly page: Store<Page>;
  readonly operations: Operations;
  readonly ticker: Ticker;
}

/** Hears the first gamepad while there is one; it counts as let go when the page is left. */
export class Gamepads {
  private readonly hand: PadHand;
  private stop: (() => void) | null = null;

  constructor(private readonly parts: PadParts) {
    const { targetControl, live, page, operations } = parts;
    this.hand = new PadHand({
      press: () => targetControl.press(),
      move: (point) => targetControl.move(point, false, true),
      release: () => targetControl.release(),
      hold: () => operations.holdByKey(),
      reference: () => live.telemetry?.point("p_ref") ?? null,
      speed: () => Math.min(FULL_STICK, page.get().settings?.speed_max ?? FULL_STICK),
    });
  }

  start(): void {
    window.addEventListener("gamepadconnected", () => {
      this.stop ??= this.parts.ticker.every(RATE, "gamepad", (now) => {
        this.poll(now);
      });
    });
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.hand.lose();
    });
    window.addEventListener("blur", () => this.hand.lose());
  }

  private poll(now: number): void {
    const pad = navigator.getGamepads().find((found) => found?.connected);
    this.parts.page.patch({ gamepad: pad ? nameOf(pad.id) : "" });
    if (pad && document.hasFocus()) this.hand.take(readingOf(pad), now);
    else this.hand.lose();
    if (pad) return;
    this.stop?.();
    this.stop = null;
  }
}

/** The maker's name without the numbers that the browser adds. */
function nameOf(id: string): string {
  return id.replace(/\s*\((STANDARD|Vendor|.*Vendor:).*$/i, "").trim() || "Gamepad";
}

/** What a gamepad says at one moment: left stick (right and up positive, -1..1) and two buttons. */
export interface Reading {
  readonly x: number;
  readonly y: number;
  readonly clutch: boolean;
  readonly hold: boolean;
}

/** What the gamepad's hand acts on. */
export interface Grip {
  /** A fresh press: take the target where it stands; null if it may not move now. */
  press(): Point | null;
  /** The target is wanted at `point` [m]; false: it may not move any more. */
  move(point: Point): boolean;
  release(): void;
  hold(): void;
  /** The rig's reference [m]. */
  reference(): Point | null;
  /** Speed of the full stick [m/s]. */
  speed(): number;
}

const DEAD_ZONE = 0.15;
/** The target runs at most this far ahead of the reference: out of reach it waits at the edge [m]. */
const LEAD = 0.02;
/** A reading later than this moves the target no further [s]. */
const STEP_MAX_S = 0.05;
const A = 0;
const B = 1;
const RIGHT_SHOULDER = 5;

/** The left stick and the buttons of the standard mapping. */
export function readingOf({ axes, buttons }: Pick<Gamepad, "axes" | "buttons">): Reading {
  const pressed = (index: number) => buttons.at(index)?.pressed ?? false;
  return {
    x: axes.at(0) ?? 0,
    y: -(axes.at(1) ?? 0),
    clutch: pressed(A) || pressed(RIGHT_SHOULDER),
    hold: pressed(B),
  };
}

/** Share of the full speed per direction: nothing within the dead zone, then as the square, for a fine hand. */
export function stickSpeed({ x, y }: Pick<Reading, "x" | "y">): Point {
  const length = Math.hypot(x, y);
  if (length <= DEAD_ZONE) return [0, 0];
  const share = Math.min(1, (length - DEAD_ZONE) / (1 - DEAD_ZONE)) ** 2;
  return [(share * x) / length, (share * y) / length];
}

/** Moves the target while the clutch button is held; the stick alone moves nothing, and nothing moves before a press. */
export class PadHand {
  private at: Point | null = null;
  /** Buttons as last seen. One that is down when the gamepad is met was not pressed for us. */
  private before = { clutch: true, hold: true };
  private seen = NaN;

  constructor(private readonly grip: Grip) {}

  /** Take a reading at page time `now` [ms]. */
  take(reading: Reading, now: number): void {
    const { clutch, hold } = reading;
    const pressed = { clutch: clutch && !this.before.clutch, hold: hold && !this.before.hold };
    this.before = { clutch, hold };
    const step = Math.min(STEP_MAX_S, (now - this.seen) / 1e3);
    this.seen = now;
    if (!clutch) this.letGo();
    if (pressed.hold) {
      this.at = null;
      this.grip.hold();
    } else if (pressed.clutch) this.at = this.grip.press();
    else if (this.at && step > 0) this.steer(this.at, stickSpeed(reading), step);
  }

  /** The gamepad is gone, or the page no longer hears it. */
  lose(): void {
    this.before = { clutch: true, hold: true };
    this.letGo();
  }

  private letGo(): void {
    if (this.at) this.grip.release();
    this.at = null;
  }

  private steer(at: Point, [vx, vy]: Point, step: number): void {
    if (vx === 0 && vy === 0) return;
    const way = this.grip.speed() * step;
    const next = leashed(at, [at[0] + vx * way, at[1] + vy * way], this.grip.reference());
    this.at = this.grip.move(next) ? next : null;
  }
}

/** Where the stick moves `at`: towards `point`, no further ahead than LEAD. A target that is ahead already stays so: it
 * never goes further than the stick says. */
function leashed(at: Point, point: Point, reference: Point | null): Point {
  if (!reference) return point;
  const lead = Math.max(LEAD, Math.hypot(at[0] - reference[0], at[1] - reference[1]));
  const [dx, dy] = [point[0] - reference[0], point[1] - reference[1]];
  const distance = Math.hypot(dx, dy);
  if (distance <= lead) return point;
  return [reference[0] + (dx * lead) / distance, reference[1] + (dy * lead) / distance];
}
