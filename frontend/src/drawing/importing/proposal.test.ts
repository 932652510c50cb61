import { expect, test } from "vitest";
import type { Point, ProposedColumn } from "../../api/types";
import { assigned, chosen, nameOf, openQuestion, sizeOf, type Meaning } from "./proposal";

function column(name: Meaning | null, unit: string | null, stated = false): ProposedColumn {
  return { title: "any", name, unit, stated };
}

test("a column that is taken as x is so alone, and none is two things", () => {
  const columns = [column("t", "s"), column("x", "m"), column("y", "m"), column(null, null)];
  expect(assigned(columns, 3, "x")).toEqual({ t: 1, x: 4, y: 3 });
  expect(assigned(columns, 1, "y")).toEqual({ t: 1, x: 0, y: 2 });
  expect(assigned(columns, 0, null)).toEqual({ t: 0, x: 2, y: 3 });
});

test("choices that follow each other fast count all, before the server has answered the first", () => {
  const columns = [column(null, null), column(null, null), column("t", "ms", true)];
  const first = assigned(columns, 0, "x");
  const second = { ...first, ...assigned(chosen(columns, first), 1, "y"), length_unit: "mm" as const };
  expect(chosen(columns, second)).toEqual([column("x", "mm"), column("y", "mm"), column("t", "ms", true)]);
  expect(chosen(columns, {})).toEqual(columns);
});

test("what neither the file nor a person says is asked for, one thing after the other", () => {
  expect(openQuestion([column(null, null), column(null, null)])).toBe("Say which column is x and which is y");
  expect(openQuestion([column("x", "mm"), column(null, null)])).toBe("Say which column is y");
  expect(openQuestion([column("x", "mm", true), column("y", null)])).toContain("in which unit x and y are");
  expect(openQuestion([column("t", null), column("x", "mm"), column("y", "mm")])).toContain(
    "in which unit t is",
  );
  expect(openQuestion([column("t", "s"), column("x", "mm"), column("y", "mm")])).toBe("");
});

test.each([
  ["path.csv", "path"],
  ["Größe 2/α.final.svg", "Gro-e 2-.final"],
  [".hidden", "hidden"],
  ["  -a .csv.csv", "a"],
  [`${"x".repeat(100)}.csv`, "x".repeat(80)],
  ["βγ.csv", ""],
])("a file %j gives a drawing the name %j", (file, name) => {
  expect(nameOf(file)).toBe(name);
});

test("the length is that of the strokes, not of the ways between them", () => {
  const strokes: Point[][] = [[[0, 0], [0.03, 0.04]], [[1, 0], [1, 0.5]]]; // prettier-ignore
  const { length, width, height } = sizeOf(strokes);
  expect([length, width, height]).toEqual([
    expect.closeTo(0.55, 9),
    expect.closeTo(1, 9),
    expect.closeTo(0.5, 9),
  ]);
});
