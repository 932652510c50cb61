import { expect, test } from "vitest";
import { gridFor, lengthLabel, ticks } from "./paper";

test("grid lines stand on round numbers at any zoom", () => {
  for (const scale of [120, 850, 9000, 90_000]) {
    const { minor, major, bar } = gridFor(scale);
    expect(major * scale).toBeGreaterThanOrEqual(60);
    expect(bar * scale).toBeLessThan(200);
    expect(Math.round(major / minor)).toBeCloseTo(major / minor, 9);
  }
  expect(ticks(-0.025, 0.031, 0.01).map((x) => Math.round(x * 1e3))).toEqual([-20, -10, 0, 10, 20, 30]);
  expect(lengthLabel(0.05)).toBe("50 mm");
});
