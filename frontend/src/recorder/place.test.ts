import { expect, test } from "vitest";
import { hashOf, placeOf } from "./place";

test.each(["", "#wall", "#review", "#review/20261121-120000-run", "#review/compare/a,b,c"])(
  "the address %s opens the place that has it",
  (hash) => {
    expect(hashOf(placeOf(hash))).toBe(hash);
  },
);

test("any other address is Live, and no more than four are compared", () => {
  expect(placeOf("#elsewhere/x").view).toBe("live");
  expect(placeOf("#review/compare/a,b,b,c,d,e").compared).toEqual(["a", "b", "c", "d"]);
  expect(placeOf("#review/%E0%A4%A").reviewed).toBe("%E0%A4%A");
});
