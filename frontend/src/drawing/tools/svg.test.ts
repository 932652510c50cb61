import { expect, test } from "vitest";
import { planePoint, unitOf } from "./svg";

test("an SVG unit is a millimetre unless its width says otherwise, and y turns upward", () => {
  expect(unitOf(null, "0 0 100 100")).toBe(1);
  expect(unitOf("100%", "0 0 100 100")).toBe(1);
  expect(unitOf("5cm", "0 0 100 100")).toBe(0.5);
  const [x, y] = planePoint({ a: 2, b: 0, c: 0, d: 1, e: 10, f: 5 }, 0.5, 20, 30);
  expect([x, y]).toEqual([expect.closeTo(0.025, 9), expect.closeTo(-0.0175, 9)]);
});
