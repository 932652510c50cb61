import { beforeEach, expect, test } from "vitest";
import { TargetSender } from "./targetControl";

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
