import { expect, test } from "vitest";
import { ALL_RODS, bearing, bit, markedText, whyUnseen } from "./rods";

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
