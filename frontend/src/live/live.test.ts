import { expect, test } from "vitest";
import { OnTime } from "./live";
import { Trail } from "./trail";

test("the on-time share counts the last minute and starts again with the rig", () => {
  const meter = new OnTime();
  for (let s = 0; s <= 100; s++) meter.add(1000 * s, s <= 20 ? 10 * s : 200, s);
  expect(meter.share()).toBe(1);
  meter.add(0, 0, 101);
  expect(meter.share()).toBeNaN();
  meter.add(1000, 10, 102);
  expect(meter.share()).toBeCloseTo(0.99, 9);
});

test("the trail shows two seconds, oldest first, fading", () => {
  const trail = new Trail();
  for (let i = 0; i < 400; i++) trail.push(i, 0, i / 100);
  const seen: number[] = [];
  trail.visit(3.99, (x, _y, freshness) => {
    seen.push(x);
    expect(freshness).toBeGreaterThan(0);
  });
  expect(seen.at(0)).toBeGreaterThan(180);
  expect(seen.at(-1)).toBe(399);
});
