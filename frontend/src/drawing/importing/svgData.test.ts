import { expect, test } from "vitest";
import { pathFault, pointsFault } from "./svgData";

test("path data of every kind is read whole, numbers without blanks too", () => {
  for (const data of [
    "",
    "M 0 0",
    "m1.5.5-3-.5z m1e1,2h4E-1v+.5",
    "M10 10a20 20 0 0140 0 20 20 0 11-40,0",
    "M0,0 C 1 2 3 4 5 6 1 2 3 4 5 6 S 1 2 3 4 Q 1 2 3 4 T 5 6 L 1 2 3 4 H 1 2 V 3 Z l 1 1",
    " M\n1\t2 L 3 , 4 ",
  ])
    expect(pathFault(data), data).toBe("");
});

test("where path data cannot be read is said with its place and text", () => {
  expect(pathFault("M 0 0 X 5")).toBe('from character 7 ("X 5") on');
  expect(pathFault("M 0 0 L 60")).toBe("from character 11, where it ends, on");
  expect(pathFault("M10,10,H,50")).toBe('from character 7 (",H,50") on');
  expect(pathFault("M 0 0 A 5 5 0 2 0 9 9")).toBe('from character 15 ("2 0 9 9") on');
  expect(pathFault("M 0 0 L NaN 1")).toContain('("NaN 1")');
  expect(pathFault("M 0 0 H 5e")).toContain('("e")');
  expect(pathFault("L 1 1")).toContain("begins with L, not with M");
  expect(pathFault("M 0 0 C 1 2 3 4")).toContain("where it ends");
});

test("points are pairs of numbers and nothing else", () => {
  for (const points of ["", "1,2 3,4", "1 2 3 4", "1-2.5.5 4"]) expect(pointsFault(points), points).toBe("");
  expect(pointsFault("1,2 3")).toContain("3 numbers: the last x has no y");
  expect(pointsFault("1,2 foo 3,4")).toBe('from character 5 ("foo 3,4") on');
});
