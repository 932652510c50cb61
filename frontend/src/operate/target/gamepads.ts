import type { Live } from "../../live/live";
import type { Page } from "../../live/page";
import type { Store } from "../../ui/store";
import type { Ticker } from "../../ui/ticker";
import type { Operations } from "../operations";
import type { TargetControl } from "./targetControl";
import { PadHand, readingOf } from "./gamepad";

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
      release: () => {
        targetControl.release();
      },
      hold: () => {
        operations.holdByKey();
      },
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
    window.addEventListener("blur", () => {
      this.hand.lose();
    });
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
