import { expect, test } from "vitest";
import { dragged } from "./gestures";
import { SPAN_MAX_S, SPAN_MIN_S } from "./view";

const TEN = { from: 100, to: 110 };

test("one finger takes the time along", () => {
  expect(dragged(TEN, 200, [[50, 9]], [[90, 0]])).toEqual({ from: 98, to: 108 });
});

test("what is under two fingers stays under them, however they lie", () => {
  const apart = dragged(TEN, 200, [[80, 5], [120, 5]], [[40, 5], [120, 5]]); // prettier-ignore
  expect(apart).toEqual({ from: 103, to: 108 });
  const upright = dragged(TEN, 200, [[100, 0], [100, 80]], [[100, 0], [100, 40]]); // prettier-ignore
  expect(upright).toEqual({ from: 95, to: 115 });
});

test("fingers that meet, or never end to go apart, stay within what can be shown", () => {
  expect(dragged(TEN, 200, [[100, 0], [140, 0]], [[100, 0], [101, 0]])).toEqual({ from: 95.95, to: 115.95 }); // prettier-ignore
  const [near, far] = [[[0, 0], [20, 0]], [[0, 0], [1e6, 0]]] as const; // prettier-ignore
  const [short, long] = [dragged(TEN, 200, near, far), dragged(TEN, 200, far, near)];
  expect([short.to - short.from, long.to - long.from].map((width) => Number(width.toFixed(6)))).toEqual([SPAN_MIN_S, SPAN_MAX_S]); // prettier-ignore
});
