import { SPAN_MAX_S, SPAN_MIN_S, type Gesture, type Range } from "./view";

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
    over.addEventListener("dblclick", () => say({ kind: "whole" }), { signal }); // prettier-ignore
    over.addEventListener("mousedown", () => say({ kind: "hold", held: true }), { signal }); // prettier-ignore
    window.addEventListener("mouseup", () => say({ kind: "hold", held: false }), { signal }); // prettier-ignore
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

/** Where a finger is on a chart [px]. */
type Place = readonly [number, number];

/** A finger that went less far than this only taps. */
const TAP_PX = 6;
/** Fingers nearer to each other than this count as this far apart: a picture must not jump when they meet. */
const NEAREST_PX = 20;

/** The range after fingers went from `before` to `after` on a chart `width` wide [px]: times stay under them. */
export function dragged(
  range: Range,
  width: number,
  before: readonly Place[],
  after: readonly Place[],
): Range {
  const long = range.to - range.from;
  const wanted = Math.min(SPAN_MAX_S, Math.max(SPAN_MIN_S, (long * spread(before)) / spread(after)));
  const held = range.from + (middle(before) / width) * long;
  const from = held - (middle(after) / width) * wanted;
  return { from, to: from + wanted };
}

/** Fingers on a chart: one drags the time along, two stretch it. */
class Touches {
  private readonly fingers = new Map<number, Place>();
  /** What is shown while it is being dragged; the chart itself is a frame late. */
  private range: Range | null = null;

  constructor(
    private readonly over: HTMLElement,
    private readonly timeAt: (px: number) => number,
    private readonly say: (gesture: Gesture) => void,
    signal: AbortSignal,
  ) {
    over.addEventListener("pointerdown", this.down, { signal });
    over.addEventListener("pointermove", this.move, { signal });
    over.addEventListener("pointerup", this.up, { signal });
    over.addEventListener("pointercancel", this.up, { signal });
  }

  private readonly down = (event: PointerEvent): void => {
    if (event.pointerType === "touch" && this.fingers.size < 2)
      this.fingers.set(event.pointerId, this.placeOf(event));
  };

  private readonly move = (event: PointerEvent): void => {
    const last = this.fingers.get(event.pointerId);
    const place = this.placeOf(event);
    if (!last || (!this.range && this.fingers.size === 1 && distance(last, place) < TAP_PX)) return;
    const { width } = this.over.getBoundingClientRect();
    const before = [...this.fingers.values()];
    this.fingers.set(event.pointerId, place);
    const shown = this.range ?? { from: this.timeAt(0), to: this.timeAt(width) };
    this.range = dragged(shown, width, before, [...this.fingers.values()]);
    this.say({ kind: "zoom", ...this.range });
  };

  private readonly up = (event: PointerEvent): void => {
    this.fingers.delete(event.pointerId);
    if (this.fingers.size === 0) this.range = null;
  };

  private placeOf({ clientX, clientY }: PointerEvent): Place {
    const { left, top } = this.over.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }
}

function middle(places: readonly Place[]): number {
  return places.reduce((sum, [x]) => sum + x, 0) / places.length;
}

/** How far apart two fingers count as; one finger stretches nothing. */
function spread(places: readonly Place[]): number {
  return places.length < 2 ? 1 : Math.max(NEAREST_PX, distance(places[0], places[1]));
}

function distance(a: Place, b: Place): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}
