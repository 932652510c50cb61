import { expect, test } from "vitest";
import type { FromBrowser, Point } from "../../api/types";
import { Aim } from "./aim";
import { PadHand, readingOf, stickSpeed, type Grip, type Reading } from "./gamepad";
import { gradeOf } from "../../health/health";
import { KeyMap } from "./keys";
import { Live } from "../../live/live";
import { MODE } from "../../rig/modes";
import { Operations } from "../operations";
import { EMPTY_PAGE, withLines, type Page } from "../../live/page";
import { Seeded } from "../../ui/seeded";
import { Store } from "../../ui/store";

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

test("after a stop by the rig the held stick moves nothing until the button is pressed anew", () => {
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

const arrow = {
  key: "ArrowUp",
  shiftKey: false,
  ctrlKey: false,
  altKey: false,
  metaKey: false,
  repeat: false,
};

test("the last arrow that comes up lets go, and so does a window that loses the keys", () => {
  const keys = new KeyMap();
  keys.press(arrow, "page", 0);
  keys.press({ ...arrow, key: "ArrowLeft" }, "page", 0);
  expect(keys.lift("ArrowUp")).toBeNull();
  expect(keys.lift("ArrowLeft")).toEqual({ kind: "release" });
  expect(keys.lift("ArrowLeft")).toBeNull();
  keys.press(arrow, "page", 0);
  expect(keys.liftAll()).toEqual({ kind: "release" });
  expect(keys.liftAll()).toBeNull();
});

test("letting go is said once, after the last move; with the clutch on no move comes after it", () => {
  const sent: FromBrowser[] = [];
  const lease = { held: true, mine: true, holder: "me", clutch: true };
  const page = new Store<Page>({ ...EMPTY_PAGE, online: true, rigLive: true, mode: MODE.HOLD, lease });
  const aim = new Aim(new Live(), page, new Operations(page, () => undefined), (message) => {
    sent.push(message);
    return true;
  });
  aim.release();
  expect(sent).toEqual([]);
  aim.move([0.1, 0], true, true);
  aim.move([0.2, 0], false, true);
  aim.release();
  aim.release();
  expect(sent.map(({ type }) => type)).toEqual(["target", "release"]);
});

test("a log that is told anew adds only what was missed, newest first", () => {
  const event = (time: string, text: string) => ({ type: "event", level: "info", time, text }) as const;
  const first = event("2026-01-01T10:00:00.100000Z", "arm");
  const local = event("2026-01-01T10:00:01.000Z", "no answer");
  const later = event("2026-01-01T10:00:02.500000Z", "hold");
  const log = withLines(withLines([], [first]), [local]);
  const told = withLines(log, [first, later]);
  expect(told.map(({ text }) => text)).toEqual(["hold", "no answer", "arm"]);
  expect(withLines(told, [first, later])).toBe(told);
});

test("a gauge is graded by its limits, a missing value by none", () => {
  expect([1, 0.9985, 0.98, NaN].map((share) => gradeOf("onTime", share))).toEqual([
    "good",
    "warning",
    "bad",
    "unknown",
  ]);
  expect([0.01, 0.06, 0.2].map((time) => gradeOf("roundTrip", time))).toEqual(["good", "warning", "bad"]);
  expect(gradeOf("ledger", -5e-3)).toBe("bad");
});
