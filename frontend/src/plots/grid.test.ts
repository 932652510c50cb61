import { expect, test } from "vitest";
import { gridOf } from "./grid";

const placed = (plots: number, width: number, height: number) => {
  const { rows, columns, cells } = gridOf(plots, { width, height });
  return { rows, columns, at: cells.map(({ column, row, rows: span }) => `${column},${row}+${span}`) };
};

test("plots stand in a row while all have room", () => {
  expect(placed(4, 1300, 200)).toEqual({ rows: 1, columns: 4, at: ["0,0+1", "1,0+1", "2,0+1", "3,0+1"] });
});

test("plots without room in a row stand above one another, column by column", () => {
  expect(placed(4, 760, 270)).toEqual({ rows: 2, columns: 2, at: ["0,0+1", "0,1+1", "1,0+1", "1,1+1"] });
});

test("the last plot takes what is left of its column, down to the time axis", () => {
  expect(placed(5, 760, 270).at).toEqual(["0,0+1", "0,1+1", "1,0+1", "1,1+1", "2,0+2"]);
  expect(placed(3, 300, 380)).toEqual({ rows: 3, columns: 1, at: ["0,0+1", "0,1+1", "0,2+1"] });
});

test("plots that would get too low stay in as many rows as are high enough, and scroll", () => {
  expect(placed(8, 1300, 190)).toMatchObject({ rows: 1, columns: 8 });
  expect(placed(4, 314, 300)).toMatchObject({ rows: 2, columns: 2 });
});

test("no plot and no room yet are a grid of one row", () => {
  expect(placed(0, 1300, 200)).toEqual({ rows: 1, columns: 0, at: [] });
  expect(placed(3, 0, 0)).toMatchObject({ rows: 1, columns: 3 });
});
