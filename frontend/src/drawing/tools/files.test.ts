import { expect, test } from "vitest";
import { ImportError, parseCsv } from "./csv";
import { planePoint, unitOf } from "./svg";

test("a CSV is read in the unit of its header, else in mm where metres make no sense", () => {
  expect(parseCsv("t [s],x [mm],y [mm]\n5,1,2\n6,1.5,2\n")).toEqual({
    points: [[1e-3, 2e-3], [1.5e-3, 2e-3]], // prettier-ignore
    times: [0, 1],
  });
  expect(parseCsv("# a comment\nx;y\n100;50\n100;60").points.map((p) => p[0])).toEqual([0.1, 0.1]);
  expect(parseCsv("0.1 0.05\n0.2 0.05").points).toEqual([[0.1, 0.05], [0.2, 0.05]]); // prettier-ignore
  expect(parseCsv("x_m,y_m\n1,1\n1,1.5").points[1]).toEqual([1, 1.5]);
});

test("a file that is no path says why", () => {
  expect(() => parseCsv("hello")).toThrow(ImportError);
  expect(() => parseCsv("1,2\n3,x")).toThrow('Row 2: "x" is not a number');
  expect(() => parseCsv("0,1,1\n0,2,2")).toThrow("Times do not rise");
  expect(() => parseCsv("1,2,3,4\n1,2,3,4")).toThrow("4 columns");
});

test("an SVG unit is a millimetre unless its width says otherwise, and y turns upward", () => {
  expect(unitOf(null, "0 0 100 100")).toBe(1);
  expect(unitOf("100%", "0 0 100 100")).toBe(1);
  expect(unitOf("5cm", "0 0 100 100")).toBe(0.5);
  const [x, y] = planePoint({ a: 2, b: 0, c: 0, d: 1, e: 10, f: 5 }, 0.5, 20, 30);
  expect([x, y]).toEqual([expect.closeTo(0.025, 9), expect.closeTo(-0.0175, 9)]);
});
