import { expect, test } from "vitest";
import { typedNumber } from "./typed";

test("a number field's text is the number that it shows, whatever zeros it has", () => {
  const meant: [string | number, number][] = [
    ["0.10", 0.1],
    ["2.0", 2],
    ["25.", 25],
    ["05", 5],
    ["-0.0", -0],
    [".5", 0.5],
    [7.25, 7.25],
  ];
  for (const [typed, value] of meant) expect(typedNumber(typed)).toBe(value);
});

test("nothing, a sign or a point alone is no number yet", () => {
  for (const typed of ["", " ", "-", ".", "-.", NaN]) expect(typedNumber(typed)).toBeNull();
});
