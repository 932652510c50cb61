import { expect, test } from "vitest";
import { hull, reachQuads, signedArea } from "./reach";

test("the quads of the reach all turn alike, where the map folds over too", () => {
  const points: [number, number][] = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [1.2, 0.5], [0.4, 0.5], [2, 2]]; // prettier-ignore
  const quads = reachQuads({ rows: 3, columns: 3, points, length: 1 });
  expect(quads).toHaveLength(4);
  for (const quad of quads) expect(signedArea(quad)).toBeGreaterThan(0);
});

test("the hull keeps the outer points only, counter-clockwise", () => {
  const points: [number, number][] = [[1, 1], [0, 0], [2, 0], [1, 0], [2, 2], [0, 2], [0.5, 1.5]]; // prettier-ignore
  expect(hull(points)).toEqual([[0, 0], [2, 0], [2, 2], [0, 2]]); // prettier-ignore
});
