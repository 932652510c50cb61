import { beforeEach, expect, test } from "vitest";
import { Aim } from "./aim";
import { Live } from "../../live/live";
import { MODE } from "../../rig/modes";
import { Operations } from "../operations";
import { EMPTY_PAGE } from "../../live/page";
import { Store } from "../../ui/store";
import { handleOf, type RigTarget } from "./handle";
import { TargetSender } from "./target";

interface Sent {
  readonly id: number;
  readonly x: number;
  readonly start?: boolean;
}

/** A clock in the test's hand, and what went out. */
class Bench {
  now = 0;
  open = true;
  readonly sent: Sent[] = [];
  private timers: { at: number; action: () => void }[] = [];
  readonly sender = new TargetSender({
    send: (message) => {
      if (this.open) this.sent.push(message);
      return this.open;
    },
    now: () => this.now,
    later: (action, delay) => this.timers.push({ at: this.now + delay, action }),
  });

  advance(ms: number): void {
    const end = this.now + ms;
    for (;;) {
      const due = this.timers
        .filter((timer) => timer.at <= end)
        .sort((a, b) => a.at - b.at)
        .at(0);
      if (!due) break;
      this.timers = this.timers.filter((timer) => timer !== due);
      this.now = due.at;
      due.action();
    }
    this.now = end;
  }
}

let bench: Bench;
beforeEach(() => {
  bench = new Bench();
});

test("moves within 4 ms go out as one message with the newest point, ids rising", () => {
  bench.sender.move([1, 0], true);
  bench.sender.move([2, 0], false);
  bench.sender.move([3, 0], false);
  bench.advance(10);
  expect(bench.sent.map(({ id, x }) => [id, x])).toEqual([[1, 1], [2, 3]]); // prettier-ignore
});

test("a fresh press is never lost to a newer move", () => {
  bench.sender.move([0, 0], false);
  bench.sender.move([1, 0], true);
  bench.sender.move([2, 0], false);
  bench.advance(10);
  expect(bench.sent.at(-1)).toMatchObject({ x: 2, start: true });
});

test("a slow rig is not buried: at most four wait, and an answer lets the newest wish go", () => {
  for (let i = 0; i < 20; i++) {
    bench.sender.move([i, 0], false);
    bench.advance(5);
  }
  expect(bench.sent).toHaveLength(4);
  bench.sender.answered(1);
  expect(bench.sent.at(-1)).toMatchObject({ id: 5, x: 19 });
});

test("a rig that never answers is asked again after a quarter of a second", () => {
  for (let i = 0; i < 6; i++) {
    bench.sender.move([i, 0], false);
    bench.advance(5);
  }
  bench.advance(300);
  expect(bench.sent.at(-1)?.x).toBe(5);
});

test("the round trip is timed from the pointer event, and an answer settles all older ones", () => {
  bench.sender.move([0, 0], false);
  bench.advance(1);
  bench.sender.move([1, 0], false);
  bench.advance(9);
  bench.sender.answered(2);
  bench.sender.answered(1);
  expect(bench.sender.roundTrips).toEqual([9]);
});

test("after a lost connection an old wish does not come alive", () => {
  bench.open = false;
  bench.sender.move([1, 0], true);
  bench.sender.move([2, 0], false);
  bench.sender.reset();
  bench.open = true;
  bench.advance(500);
  expect(bench.sent).toEqual([]);
});

const rig: RigTarget = { mode: MODE.FOLLOW, target: [0.1, 0.1], reference: [0.09, 0.1], tip: [0.08, 0.1] };

test("a moved handle is hollow until the rig echoes it", () => {
  const wish = { point: [0.2, 0.1], at: 0, held: true } as const;
  expect(handleOf(wish, rig, 0)).toEqual({ point: [0.2, 0.1], acknowledged: false, movable: true });
  expect(handleOf(wish, { ...rig, target: [0.2, 0.1] }, 0)?.acknowledged).toBe(true);
});

test("a wish that the rig did not take gives way to where the rig is", () => {
  const wish = { point: [0.2, 0.1], at: 0, held: false } as const;
  expect(handleOf(wish, rig, 1000)?.point).toEqual([0.1, 0.1]);
  expect(handleOf(wish, { ...rig, mode: MODE.HOLD }, 1000)).toMatchObject({
    point: [0.09, 0.1],
    acknowledged: false,
  });
});

test("while vented the handle rests on the tip and cannot be moved", () => {
  expect(handleOf(null, { ...rig, mode: MODE.VENTED }, 0)).toMatchObject({
    point: [0.08, 0.1],
    movable: false,
  });
});

test("when the rig falls to HOLD in the middle of a drag, the drag moves nothing until a new press", () => {
  const lease = { held: true, mine: true, holder: "me", clutch: false };
  const page = new Store({ ...EMPTY_PAGE, online: true, rigLive: true, lease });
  const aim = new Aim(new Live(), page, new Operations(page, () => undefined), () => true);
  page.patch({ mode: MODE.HOLD });
  expect(aim.move([0.1, 0], true, true)).toBe(true);
  expect(aim.move([0.11, 0], false, true)).toBe(true);
  page.patch({ mode: MODE.FOLLOW });
  expect(aim.move([0.12, 0], false, true)).toBe(true);
  page.patch({ mode: MODE.HOLD });
  expect(aim.move([0.13, 0], false, true)).toBe(false);
  expect(page.get().hint).toContain("press again");
  expect(aim.move([0.13, 0], true, true)).toBe(true);
  page.patch({ mode: MODE.VENTED });
  expect(aim.move([0.14, 0], true, true)).toBe(false);
  expect(page.get().hint).toBe("Arm first");
});
