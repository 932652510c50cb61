import { expect, test } from "vitest";
import type { Point } from "../../api/types";
import { arrowEnd, markersOf, missOf, residualOf, type PointSource } from "./residual";

/** Ten sensors on a straight backbone of 21 samples; markers 3 mm beside it, the fourth not seen. */
const source: PointSource = {
  points: (name) => (name === "markers" ? 10 : 21),
  point: (name, i) => (name === "backbone" ? [i * 0.01, 0] : i === 3 ? null : [(i + 1) * 0.02, 0.003]),
  at: () => 0b10_0010_0000,
};

test("a marker is compared with the observer's point at the same arc length", () => {
  const markers = markersOf(source);
  expect(markers.map((marker) => marker.rod)).toEqual([1, 2, 3, 5, 6, 7, 8, 9, 10]);
  for (const marker of markers) {
    expect(marker.observed?.[0]).toBeCloseTo(marker.measured[0], 12);
    expect(residualOf(marker)).toBeCloseTo(0.003, 12);
  }
});

test("only the rods whose bits are set are sensed", () => {
  expect(
    markersOf(source)
      .filter((marker) => marker.sensed)
      .map((marker) => marker.rod),
  ).toEqual([6, 10]);
});

test("a residual arrow points from the observer to the measurement, lengthened by its gain", () => {
  expect(arrowEnd([0.1, 0], [0.101, -0.002], 5)).toEqual([expect.closeTo(0.105), expect.closeTo(-0.01)]);
});

test("the miss of a rod is the distance between estimate and truth at its arc length, nan without a twin", () => {
  const source = {
    points: (name: string) => (name === "markers" ? 10 : 21),
    point: (name: string, index: number): Point | null => [index, name === "backbone" ? 3e-3 : -1e-3],
  };
  expect(missOf(source, 6)).toBeCloseTo(4e-3, 12);
  expect(missOf({ ...source, point: () => null }, 6)).toBeNaN();
});
