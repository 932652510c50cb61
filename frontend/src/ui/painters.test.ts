import { beforeEach, expect, test, vi } from "vitest";
import { Painters, RETRY_MS } from "./painters";
import { Store } from "./store";
import { Ticker } from "./ticker";

let frames: ((now: number) => void)[] = [];
let told: string[] = [];
let now = 0;

beforeEach(() => {
  frames = [];
  told = [];
  now = 0;
  vi.stubGlobal("requestAnimationFrame", (run: (now: number) => void) => frames.push(run));
});

const painters = () => new Painters((name) => told.push(name));

/** Let `count` frames of 20 ms pass. */
function pass(count: number): void {
  for (let i = 0; i < count; i++) {
    now += 20;
    for (const run of frames.splice(0)) run(now);
  }
}

test("a painter that throws stops no other, is noted once, and is tried again once a second", () => {
  const all = painters();
  const ticker = new Ticker(all);
  const calls = { bad: 0, good: 0 };
  ticker.every(60, "bad", () => {
    calls.bad += 1;
    throw new Error("broken");
  });
  ticker.every(60, "good", () => {
    calls.good += 1;
  });
  pass(200);
  expect(calls.good).toBe(200);
  expect(calls.bad).toBeGreaterThanOrEqual(3);
  expect(calls.bad).toBeLessThanOrEqual(1 + 4000 / RETRY_MS);
  expect(told).toEqual(["bad"]);
  expect(all.failed.get().names).toEqual(["bad"]);
});

test("one that recovers paints at its rate again, and is no longer marked", () => {
  const all = painters();
  let broken = true;
  let painted = 0;
  const stop = new Ticker(all).every(60, "plan", () => {
    if (broken) throw new Error("broken");
    painted += 1;
  });
  pass(10);
  broken = false;
  pass(60);
  expect(all.failed.get().names).toEqual([]);
  const before = painted;
  pass(50);
  expect(painted - before).toBe(50);
  broken = true;
  pass(1);
  expect(all.failed.get().names).toEqual(["plan"]);
  expect(told).toEqual(["plan"]);
  stop();
  expect(all.failed.get().names).toEqual([]);
});

test("two of the same name are told apart: one that throws does not hold the other up", () => {
  const ticker = new Ticker(painters());
  let good = 0;
  ticker.every(60, "number", () => {
    throw new Error("broken");
  });
  ticker.every(60, "number", () => {
    good += 1;
  });
  pass(50);
  expect(good).toBe(50);
});

test("a listener of a store that throws does not keep the others from hearing", () => {
  vi.useFakeTimers();
  const store = new Store({ value: 0 });
  let heard = 0;
  store.subscribe(() => {
    throw new Error("broken");
  });
  store.subscribe(() => (heard += 1));
  store.patch({ value: 1 });
  expect(heard).toBe(1);
  expect(() => vi.runAllTimers()).toThrow("broken");
  vi.useRealTimers();
});
