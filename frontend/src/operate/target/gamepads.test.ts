import { expect, test } from "vitest";
import type { Point } from "../../api/types";
import { Seeded } from "../../ui/seeded";
import { PadHand, readingOf, stickSpeed, type Grip, type Reading } from "./gamepads";

class Hand implements Grip {
  readonly calls: string[] = [];
  at: Point = [0.2, 0];
  allowed = true;
  reference(): Point | null {
    return [0.2, 0];
  }
  speed = () => 0.1;
  press(): Point | null {
    this.calls.push("press");
    return this.allowed ? this.at : null;
  }
  move(point: Point): boolean {
    this.calls.push("move");
    if (this.allowed) this.at = point;
    return this.allowed;
  }
  release(): void {
    this.calls.push("release");
  }
  hold(): void {
    this.calls.push("hold");
  }
}

const rest: Reading = { x: 0, y: 0, clutch: false, hold: false };

const right: Reading = { ...rest, x: 1, clutch: true };

function padOf(): { hand: Hand; feed: (...readings: Reading[]) => void } {
  const hand = new Hand();
  const pad = new PadHand(hand);
  let now = 0;
  return {
    hand,
    feed: (...readings) => {
      for (const reading of readings) pad.take(reading, (now += 10));
    },
  };
}

test("the stick moves the target at its speed while the clutch button is held, and only then", () => {
  const { hand, feed } = padOf();
  feed(rest, { ...rest, x: 1 }, { ...rest, x: 1 });
  expect(hand.calls).toEqual([]);
  feed(right, right, right);
  expect(hand.at[0]).toBeCloseTo(0.202, 9);
  feed(rest, { ...rest, x: 1 });
  expect(hand.calls).toEqual(["press", "move", "move", "release"]);
});

test("a button that is down when the gamepad is met is no press", () => {
  const { hand, feed } = padOf();
  feed(right, right);
  expect(hand.calls).toEqual([]);
  feed(rest, right);
  expect(hand.calls).toEqual(["press"]);
});

test("after a stop by the rig the held stick moves nothing until the button is pressed again", () => {
  const { hand, feed } = padOf();
  feed(rest, right, right);
  hand.allowed = false;
  feed(right);
  hand.allowed = true;
  const before = hand.calls.length;
  feed(right, right, right);
  expect(hand.calls).toHaveLength(before);
  feed(rest, right);
  expect(hand.calls.at(-1)).toBe("press");
});

test("B holds once per press and drops the grip", () => {
  const { hand, feed } = padOf();
  feed(rest, right, { ...right, hold: true }, { ...right, hold: true }, right);
  expect(hand.calls).toEqual(["press", "hold"]);
});

test("the target does not run away beyond the edge of the reach", () => {
  const { hand, feed } = padOf();
  feed(rest, right, ...Array.from({ length: 500 }, () => right));
  expect(hand.at[0]).toBeCloseTo(0.22, 9);
});

test("no step of the stick is longer than its speed, wherever the reference is", () => {
  for (let seed = 1; seed <= 500; seed++) {
    const random = new Seeded(seed);
    let reference: Point = [0.2, 0];
    const steps: number[] = [];
    let at: Point = [0.2 + random.between(-0.2, 0.2), random.between(-0.2, 0.2)];
    const pad = new PadHand({
      press: () => at,
      move: (point) => {
        steps.push(Math.hypot(point[0] - at[0], point[1] - at[1]));
        at = point;
        return true;
      },
      release: () => undefined,
      hold: () => undefined,
      reference: () => reference,
      speed: () => 0.1,
    });
    pad.take(rest, 0);
    for (let step = 1; step <= 50; step++) {
      reference = [reference[0] + random.between(-0.01, 0.01), reference[1] + random.between(-0.01, 0.01)];
      pad.take({ x: random.between(-1, 1), y: random.between(-1, 1), clutch: true, hold: false }, 10 * step);
    }
    expect(Math.max(...steps), `seed ${seed}`).toBeLessThanOrEqual(0.1 * 0.01 + 1e-12);
  }
});

test("the stick has a dead zone, a fine middle and one full speed in every direction", () => {
  expect(stickSpeed({ x: 0.1, y: -0.1 })).toEqual([0, 0]);
  expect(Math.hypot(...stickSpeed({ x: 1, y: 1 }))).toBeCloseTo(1, 9);
  expect(stickSpeed({ x: 0.575, y: 0 })[0]).toBeCloseTo(0.25, 9);
  const button = (pressed: boolean) => ({ pressed, touched: pressed, value: Number(pressed) });
  const pad = { axes: [0.5, -1], buttons: [button(false), button(true)] };
  expect(readingOf(pad)).toEqual({ x: 0.5, y: 1, clutch: false, hold: true });
});
