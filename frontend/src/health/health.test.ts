import { expect, test } from "vitest";
import { gradeOf } from "./health";

test("a gauge is graded by its limits, a missing value by none", () => {
  expect([1, 0.9985, 0.98, NaN].map((share) => gradeOf("onTime", share))).toEqual([
    "good",
    "warning",
    "bad",
    "unknown",
  ]);
  expect([0.01, 0.06, 0.2].map((time) => gradeOf("roundTrip", time))).toEqual(["good", "warning", "bad"]);
  expect(gradeOf("ledger", -5e-3)).toBe("bad");
});
