import { expect, test } from "vitest";
import { absolute, PIXEL, unitOf, upward } from "./svg";

/** Millimetres per unit of a root element with these attributes. */
function unit(attributes: Record<string, string>): number | null {
  return unitOf((name) => attributes[name] ?? null);
}

test("a unit is what width or height say over the view box, in every unit of length", () => {
  expect(unit({ width: "5cm", viewBox: "0 0 100 100" })).toBeCloseTo(0.5, 9);
  expect(unit({ height: "2in", viewBox: "0,0,100,50.8" })).toBeCloseTo(1, 9);
  expect(unit({ width: "72pt", viewBox: "-10 -10 25.4 25.4" })).toBeCloseTo(1, 9);
  expect(unit({ width: "60mm", height: "60mm", viewBox: "0 0 60 120" })).toBeCloseTo(0.5, 9);
  expect(unit({ width: "60mm", height: "60mm", viewBox: "0 0 60 120", preserveAspectRatio: "xMidYMid slice" })).toBeCloseTo(1, 9); // prettier-ignore
});

test("without a view box it is the pixel of CSS, and without a length nothing is said", () => {
  expect(unit({ width: "60mm" })).toBe(PIXEL);
  for (const width of ["100%", "100", "100px", "-5mm", ""])
    expect(unit({ width, viewBox: "0 0 9 9" })).toBeNull();
  expect(unit({ viewBox: "0 0 100 100" })).toBeNull();
  expect(unit({ width: "1cm", height: "2cm", viewBox: "0 0 9 9", preserveAspectRatio: "none" })).toBeNull();
});

test("y turns upward", () => {
  expect(upward({ a: 2, b: 0, c: 0, d: 1, e: 10, f: 5 }, 20, 30)).toEqual([50, -35]);
});

test("a move begins where the pen was left, and what follows it is a line of its own kind", () => {
  const pen = { x: 10, y: 20 };
  expect(absolute("m 1 2 3 4 z", pen)).toEqual({
    text: "M 11 22 l3 4 z",
    start: { x: 11, y: 22 },
    closed: true,
  });
  expect(absolute("m.5.5-1-1", pen)?.text).toBe("M 10.5 20.5 l-1-1");
  expect(absolute("M1-2,3 4L5 6", pen)).toEqual({
    text: "M 1 -2 L3 4L5 6",
    start: { x: 1, y: -2 },
    closed: false,
  });
  expect(absolute("M 1e1 2 h 5", pen)?.text).toBe("M 10 2 h 5");
  expect(absolute("L 1 2", pen)).toBeNull();
});
