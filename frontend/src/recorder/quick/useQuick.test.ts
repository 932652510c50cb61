import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { askAgain } from "./useQuick";

let asked = 0;
let waiting: (() => void)[] = [];
const slow = () => {
  asked += 1;
  return new Promise<void>((done) => waiting.push(done));
};
const answered = async () => {
  for (const done of waiting.splice(0)) done();
  await vi.advanceTimersByTimeAsync(0);
};

beforeEach(() => {
  vi.useFakeTimers();
  [asked, waiting] = [0, []];
});
afterEach(() => {
  vi.useRealTimers();
});

test("nothing is asked again before the last answer, and then only after the period", async () => {
  const end = askAgain(slow, 2000);
  await vi.advanceTimersByTimeAsync(20_000);
  expect(asked).toBe(1);
  await answered();
  await vi.advanceTimersByTimeAsync(1999);
  expect(asked).toBe(1);
  await vi.advanceTimersByTimeAsync(1);
  expect(asked).toBe(2);
  end();
});

test("nothing is asked after the end, though an answer comes later", async () => {
  const end = askAgain(slow, 2000);
  end();
  await answered();
  await vi.advanceTimersByTimeAsync(20_000);
  expect(asked).toBe(1);
});
