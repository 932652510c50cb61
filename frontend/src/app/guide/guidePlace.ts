const GAP = 12;
const EDGE = 8;
/** State and E-STOP have the upper edge. */
const TOP = 60;
/** A control larger than this is pointed at from within. */
const LARGE = 300;

interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** Put the ring round the first element that `selectors` find, and the card beside it, wholly in the window. */
export function place(card: HTMLElement, ring: HTMLElement, selectors: readonly string[]): void {
  const found = selectors
    .map((selector) => document.querySelector(selector))
    .find((element) => element !== null);
  ring.hidden = found === undefined;
  const target = found?.getBoundingClientRect() ?? { left: 0, top: 0, width: 0, height: 0 };
  move(ring, target.left - 4, target.top - 4);
  ring.style.width = `${target.width + 8}px`;
  ring.style.height = `${target.height + 8}px`;
  const at = cardPlace(target, card.getBoundingClientRect(), window.innerWidth, window.innerHeight);
  move(card, at.left, at.top);
}

/** Below the control, above it where there is no room, in the lower left corner of a large one. */
export function cardPlace(
  target: Box,
  card: Box,
  width: number,
  height: number,
): { readonly left: number; readonly top: number } {
  const below = target.top + target.height + GAP;
  const above = target.top - card.height - GAP;
  const inside = target.top + target.height - card.height - 4 * GAP;
  const large = target.width > LARGE && target.height > LARGE;
  const top = large ? inside : below + card.height + EDGE <= height ? below : above;
  return {
    left: within(target.left + (large ? GAP : 0), EDGE, width - card.width - EDGE),
    top: within(top, TOP, height - card.height - EDGE),
  };
}

function within(value: number, low: number, high: number): number {
  return Math.max(low, Math.min(value, high));
}

function move(element: HTMLElement, left: number, top: number): void {
  element.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
}
