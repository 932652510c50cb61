import { expect, test } from "vitest";
import type { Point } from "../api/types";
import { boundingBox, fit, pan, toPixel, toPlane, zoomAbout, type Size, type View } from "./transform";

const size: Size = { width: 740, height: 460 };
const view: View = { centre: [0.06, -0.02], scale: 850 };

function expectPoint(actual: Point, expected: Point): void {
  expect(actual[0]).toBeCloseTo(expected[0], 9);
  expect(actual[1]).toBeCloseTo(expected[1], 9);
}

test("plane to pixel and back is the identity, with y up", () => {
  expectPoint(toPlane(view, size, toPixel(view, size, [0.123, 0.045])), [0.123, 0.045]);
  expect(toPixel(view, size, [0, 0.1])[1]).toBeLessThan(toPixel(view, size, [0, 0])[1]);
});

test("zooming keeps the point under the pointer and both scales equal", () => {
  const pixel: Point = [100, 400];
  const before = toPlane(view, size, pixel);
  const zoomed = zoomAbout(view, size, pixel, 1.7);
  expectPoint(toPlane(zoomed, size, pixel), before);
  const [x0, y0] = toPixel(zoomed, size, [0, 0]);
  const [x1, y1] = toPixel(zoomed, size, [0.01, 0.01]);
  expect(x1 - x0).toBeCloseTo(y0 - y1, 9);
});

test("zoom stops at its limits without moving the point under the pointer", () => {
  const pixel: Point = [30, 30];
  const far = zoomAbout(view, size, pixel, 1e-9);
  expect(far.scale).toBeGreaterThan(0);
  expectPoint(toPlane(far, size, pixel), toPlane(view, size, pixel));
});

test("panning moves what is under the pointer with it", () => {
  const grabbed = toPlane(view, size, [200, 100]);
  expectPoint(toPlane(pan(view, 30, -12), size, [230, 88]), grabbed);
});

test("fit shows the whole box inside its margin", () => {
  const box = boundingBox([[-0.1, -0.2], null, [0.25, 0.2]]);
  if (!box) throw new Error("no box");
  const fitted = fit(box, size, 20);
  const [left, top] = toPixel(fitted, size, [box.left, box.top]);
  const [right, bottom] = toPixel(fitted, size, [box.right, box.bottom]);
  expect(Math.min(left, top)).toBeGreaterThanOrEqual(20 - 1e-9);
  expect(right).toBeLessThanOrEqual(size.width - 20 + 1e-9);
  expect(bottom).toBeLessThanOrEqual(size.height - 20 + 1e-9);
});
