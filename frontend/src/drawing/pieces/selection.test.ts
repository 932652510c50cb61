import { expect, test } from "vitest";
import type { Point } from "../../api/types";
import { pieceOf, placed, type Piece } from "../piece";
import { bounded, changed, changedOutline, changeOf, outlineOf, piecesIn, toggled } from "./selection";

const bar = (x: number, group: number | null = null): Piece => ({
  ...pieceOf([[x, 0.1], [x, 0.12]]), // prettier-ignore
  group,
});
const bars = [bar(0.1), bar(0.12), bar(0.14)];
const box = { centre: [0.12, 0.11] as Point, half: [0.02, 0.01] as Point, angle: 0 };

function expectPoints(actual: readonly Point[], expected: readonly Point[]): void {
  expect(actual).toHaveLength(expected.length);
  actual.forEach((point, i) => {
    expect(point[0]).toBeCloseTo(expected[i][0], 9);
    expect(point[1]).toBeCloseTo(expected[i][1], 9);
  });
}

test("one box is around all that is selected; around one piece it is turned as that is", () => {
  expect(outlineOf([])).toBeNull();
  const outline = outlineOf(bars);
  expectPoints([outline?.centre ?? [0, 0], outline?.half ?? [0, 0]], [box.centre, box.half]);
  const turned = { ...bars[0], placement: { ...bars[0].placement, angle: 0.4, scale: 3 } };
  expect(outlineOf([turned])).toMatchObject({ centre: [0.1, 0.11], half: [0, expect.closeTo(0.03, 9)], angle: 0.4 });
}); // prettier-ignore

test("handles move, scale and turn what is selected about the middle of its box, and nothing else", () => {
  const after = (grip: "move" | "scale" | "turn", from: Point, to: Point) =>
    changed(bars, [0, 2], changeOf(box.centre, grip, from, to));
  const moved = after("move", [0.1, 0.1], [0.15, 0.08]);
  expectPoints(placed(moved[0]), [[0.15, 0.08], [0.15, 0.1]]); // prettier-ignore
  expect(moved[1]).toBe(bars[1]);
  const scaled = after("scale", [0.14, 0.11], [0.16, 0.11]);
  expectPoints(placed(scaled[0]), [[0.08, 0.09], [0.08, 0.13]]); // prettier-ignore
  const turned = after("turn", [0.12, 0.15], [0.08, 0.11]);
  expectPoints(placed(turned[0]), [[0.13, 0.09], [0.11, 0.09]]); // prettier-ignore
  expectPoints(placed(turned[2]), [[0.13, 0.13], [0.11, 0.13]]); // prettier-ignore
});

test("the box of a gesture turns and grows along with what it is around", () => {
  const change = { about: box.centre, shift: [0.01, 0] as Point, angle: 0.5, scale: 2 };
  expect(changedOutline(box, change)).toEqual({ centre: [0.13, 0.11], half: [0.04, 0.02], angle: 0.5 });
});

test("no piece becomes smaller or larger than a piece may be, and the whole keeps its proportions", () => {
  const small = { ...bars[0], placement: { ...bars[0].placement, scale: 0.04 } };
  const change = { about: box.centre, shift: [0, 0] as Point, angle: 0, scale: 0.1 };
  expect(bounded(change, [small, bars[1]]).scale).toBeCloseTo(0.5, 9);
  expect(bounded({ ...change, scale: 1e9 }, [small, bars[1]]).scale).toBeCloseTo(50, 9);
  expect(bounded({ ...change, scale: NaN }, bars).scale).toBe(1);
});

test("a box selects what it meets: points, lines that pass through it, and groups as a whole", () => {
  expect(piecesIn(bars, [0.09, 0.09], [0.13, 0.105])).toEqual([0, 1]);
  expect(piecesIn(bars, [0.15, 0.112], [0.11, 0.108])).toEqual([1, 2]);
  expect(piecesIn(bars, [0.101, 0.09], [0.119, 0.13])).toEqual([]);
  const grouped = [bar(0.1, 1), bar(0.12), bar(0.14, 1)];
  expect(piecesIn(grouped, [0.09, 0.09], [0.11, 0.13])).toEqual([0, 2]);
});

test("what is added once more is taken out again", () => {
  expect(toggled([0], [2])).toEqual([0, 2]);
  expect(toggled([0, 2], [0])).toEqual([2]);
  expect(toggled([0], [0, 1])).toEqual([0, 1]);
});
