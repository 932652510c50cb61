import { SPAN_MAX_S, SPAN_MIN_S, type Gesture, type Range } from "./view";

/** Where a finger is on a chart [px]. */
export type Place = readonly [number, number];

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
export class Touches {
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
