import { expect, test } from "vitest";
import { ALL_RODS, bearing, bit, gainsText, markedText, whyUnseen } from "./rods";

test("a twin bears a marker on every rod, a rig those of its file", () => {
  expect(bearing(undefined)).toBe(ALL_RODS);
  expect(bearing([6, 10])).toBe(bit(6) | bit(10));
});

test("a rod without a marker cannot be sensed, and it is said which one", () => {
  const marked = bearing([10]);
  expect(whyUnseen(bit(10), marked)).toBeNull();
  expect(whyUnseen(bit(6) | bit(10), marked)).toBe("No marker on rod 6");
  expect(whyUnseen(0, marked)).toBeNull();
  expect(markedText(marked)).toBe("Markers on rod 10 alone");
});

const BOUNDS = { full_gains_from: 0.6, least_gains: 0.25 };

test("rods near the base say how much of P and I they are worth, others nothing", () => {
  expect(gainsText(bit(3), BOUNDS)).toBe("Rod 3 tells little of the tip: P and I at 25 % in FOLLOW and HOLD");
  expect(gainsText(bit(1), BOUNDS)).toMatch("P and I at 25 %");
  expect(gainsText(bit(1) | bit(5), BOUNDS)).toMatch("Rod 5 tells little of the tip: P and I at 69 %");
  for (const sensed of [0, bit(6), bit(10), bit(1) | bit(10)]) expect(gainsText(sensed, BOUNDS)).toBeNull();
  expect(gainsText(bit(1), { ...BOUNDS, full_gains_from: 0 })).toBeNull();
});
