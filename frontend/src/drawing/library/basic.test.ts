import { expect, test } from "vitest";
import { distance, placed } from "../piece";
import { BASIC_SHAPES, basicPiece } from "./basic";

const named = (label: string) => {
  const shape = BASIC_SHAPES.find((one) => one.label === label);
  if (!shape) throw new Error(label);
  return placed(basicPiece(shape, [0.03, 0.14]));
};

const lengthOf = (points: readonly (readonly [number, number])[]) =>
  points.reduce((sum, point, i) => sum + (i > 0 ? distance([...points[i - 1]], [...point]) : 0), 0);

test("each shape lies about the place it is given and is no larger than the paper's circle", () => {
  for (const shape of BASIC_SHAPES) {
    const points = placed(basicPiece(shape, [0.03, 0.14]));
    for (const axis of [0, 1]) {
      const values = points.map((point) => point[axis]);
      const [low, high] = [Math.min(...values), Math.max(...values)];
      expect((low + high) / 2, shape.label).toBeCloseTo([0.03, 0.14][axis], 9);
      expect(high - low, shape.label).toBeGreaterThan(0.02);
      expect(high - low, shape.label).toBeLessThan(0.0601);
    }
  }
});

test("a square has equal sides and right angles, a star ten equal edges", () => {
  const square = named("Square");
  const sides = square.map((point, i) => distance(point, square[(i + 1) % 4]));
  for (const side of sides) expect(side).toBeCloseTo(0.03 * Math.SQRT2, 9);
  expect(distance(square[0], square[2])).toBeCloseTo(0.06, 9);
  const star = named("Star");
  const edges = star.map((point, i) => distance(point, star[(i + 1) % 10]));
  expect(Math.max(...edges) - Math.min(...edges)).toBeLessThan(1e-12);
});

test("a spiral's turns are evenly apart, and a raster's rows run there and back", () => {
  const spiral = named("Spiral");
  expect(distance(spiral[180], spiral[360])).toBeCloseTo(0.01, 9);
  const raster = named("Raster");
  expect(lengthOf(raster)).toBeCloseTo(8 * 0.06 * Math.SQRT1_2, 9);
});
