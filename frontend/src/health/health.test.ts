import { expect, test } from "vitest";
import { gradeOf, worstOf } from "./health";

test("a gauge is graded by its limits, a missing value by none", () => {
  expect([1, 0.9985, 0.98, NaN].map((share) => gradeOf("onTime", share))).toEqual([
    "good",
    "warning",
    "bad",
    "unknown",
  ]);
  expect([0.01, 0.06, 0.2].map((time) => gradeOf("roundTrip", time))).toEqual(["good", "warning", "bad"]);
  expect(gradeOf("ledger", 5e-3)).toBe("bad");
  expect(gradeOf("ledger", -5e-3)).toBe("good");
});

test("the worst number is the one that is shown, and what is not known is not the worst", () => {
  expect(worstOf(["good", "warning", "bad", "bad"])).toBe(2);
  expect(worstOf(["unknown", "good", "warning"])).toBe(2);
  expect(worstOf(["unknown", "good", "good"])).toBe(1);
  expect(worstOf(["unknown", "unknown"])).toBe(0);
});
