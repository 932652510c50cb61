import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Jog, RENEW_MS } from "./jog";
import type { Chamber } from "./steps";

let sent: (Chamber | null)[] = [];
let shown: Chamber | null = null;
let failures: unknown[] = [];
let answer: () => Promise<void> = () => Promise.resolve();

beforeEach(() => {
  vi.useFakeTimers();
  [sent, shown, failures] = [[], null, []];
  answer = () => Promise.resolve();
});
afterEach(() => {
  vi.useRealTimers();
});

function jog(): Jog {
  return new Jog({
    send: (chamber) => {
      sent.push(chamber);
      return answer();
    },
    every: (action, period) => setInterval(action, period),
    show: (held) => {
      shown = held;
    },
    failed: (error) => failures.push(error),
  });
}

test("a held button is renewed at 5 Hz at least, and not after its release", async () => {
  const held = jog();
  held.press("u1+");
  await vi.advanceTimersByTimeAsync(1000);
  expect(sent.length).toBeGreaterThanOrEqual(6);
  expect(RENEW_MS).toBeLessThanOrEqual(200);
  held.release();
  await vi.advanceTimersByTimeAsync(1000);
  expect(sent.filter((chamber) => chamber === "u1+")).toHaveLength(sent.length - 1);
  expect([sent.at(-1), shown]).toEqual([null, null]);
});

test("the release is said again once every renewal has been answered: it may have overtaken one", async () => {
  const waiting: (() => void)[] = [];
  answer = () => new Promise((done) => waiting.push(done));
  const held = jog();
  held.press("u2-");
  held.release();
  expect(sent).toEqual(["u2-", null]);
  for (const done of waiting) done();
  await vi.advanceTimersByTimeAsync(0);
  expect(sent).toEqual(["u2-", null, null]);
});

test("only the button that is held lets go, and another takes its place", async () => {
  const held = jog();
  held.press("u1+");
  held.press("u2+");
  held.release("u1+");
  expect(shown).toBe("u2+");
  await vi.advanceTimersByTimeAsync(RENEW_MS);
  expect(sent.at(-1)).toBe("u2+");
});

test("a refusal lets go and is told once", async () => {
  answer = () => Promise.reject(new Error("the jog step is not under way"));
  const held = jog();
  held.press("u1+");
  await vi.advanceTimersByTimeAsync(1000);
  expect(shown).toBeNull();
  expect(failures).toHaveLength(1);
});

test("no more than three renewals are on their way to a server that does not answer", async () => {
  answer = () => new Promise(() => undefined);
  jog().press("u1+");
  await vi.advanceTimersByTimeAsync(5000);
  expect(sent).toHaveLength(3);
});
