import { expect, test } from "vitest";
import { timingOf } from "./facts";

test("another timing begins near the present one, within its bounds", () => {
  const plan = { length: 0.4, duration: 25, travel_duration: 5 } as Parameters<typeof timingOf>[1];
  expect(timingOf("speed", plan)).toEqual({ kind: "speed", speed: 0.02 });
  expect(timingOf("duration", plan)).toEqual({ kind: "duration", duration: 20 });
});
