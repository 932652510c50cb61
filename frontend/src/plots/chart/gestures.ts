import { Touches } from "./touches";
import type { Gesture } from "./view";

/** Pixels of the wheel that double the time shown. */
const DOUBLING_PX = 400;
const LINE_PX = 16;

/** Wheel, press, double-click and fingers on a chart. A press holds the picture, else what is dragged over would run away. */
export class Gestures {
  private readonly ending = new AbortController();

  constructor(
    private readonly over: HTMLElement,
    private readonly timeAt: (px: number) => number,
    private readonly say: (gesture: Gesture) => void,
  ) {
    const { signal } = this.ending;
    over.addEventListener("wheel", this.wheel, { passive: false, signal });
    over.addEventListener("dblclick", () => { say({ kind: "whole" }); }, { signal }); // prettier-ignore
    over.addEventListener("mousedown", () => { say({ kind: "hold", held: true }); }, { signal }); // prettier-ignore
    window.addEventListener("mouseup", () => { say({ kind: "hold", held: false }); }, { signal }); // prettier-ignore
    new Touches(over, timeAt, say, signal);
  }

  destroy(): void {
    this.ending.abort();
  }

  /** Up and down zoom about the pointer; sideways, or with Shift, the window moves. */
  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE_PX : 1;
    const [x, y] = [event.deltaX * unit, event.deltaY * unit];
    const { left } = this.over.getBoundingClientRect();
    const px = event.clientX - left;
    const sideways = event.shiftKey ? x + y : x;
    if (event.shiftKey || Math.abs(x) > Math.abs(y))
      this.say({ kind: "move", seconds: this.timeAt(px + sideways / 2) - this.timeAt(px) });
    else this.say({ kind: "scale", factor: 2 ** (y / DOUBLING_PX), about: this.timeAt(px) });
  };
}
