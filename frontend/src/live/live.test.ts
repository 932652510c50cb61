import { expect, test } from "vitest";
import { RoundTrip } from "./live";
import { Trail } from "./trail";

test("a round trip that is owed counts for as long as it is owed", () => {
  const trip = new RoundTrip();
  expect(trip.at(0)).toBeNaN();
  trip.sent(0);
  trip.answered(0, 14);
  expect(trip.at(4000)).toBe(0.014);
  trip.sent(5000);
  trip.sent(6000);
  expect([5010, 7000].map((now) => trip.at(now))).toEqual([0.014, 2]);
  trip.forget();
  expect(trip.at(8000)).toBeNaN();
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
