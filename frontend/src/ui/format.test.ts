import { expect, test } from "vitest";
import { bytes, clock, DASH, kilopascals, microseconds, millimetres, percent } from "./format";

test("numbers carry units, and a missing one is a dash", () => {
  expect(millimetres(0.01234)).toBe("12.3 mm");
  expect(millimetres(-0.00001)).toBe("0.0 mm");
  expect(millimetres(NaN)).toBe(DASH);
  expect(millimetres(null)).toBe(DASH);
  expect(kilopascals(118_200)).toBe("118 kPa");
  expect(percent(0.99981)).toBe("99.98 %");
  expect(microseconds(12_340)).toBe("12.3 µs");
  expect([clock(72.9), clock(3723)]).toEqual(["1:12", "1:02:03"]);
  expect([bytes(512_000), bytes(1.8e9)]).toEqual(["512 kB", "1.80 GB"]);
});
