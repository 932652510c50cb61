/** Width and height of what there is room in, or of what stands in it [px]. */
export interface Size {
  readonly width: number;
  readonly height: number;
}

/** Where a plot stands: its column, and the rows that it takes, from 0. */
export interface Cell {
  readonly column: number;
  readonly row: number;
  readonly rows: number;
}

export interface Grid {
  readonly rows: number;
  readonly columns: number;
  readonly cells: readonly Cell[];
}

/** A plot that is smaller is hard to read: it is rather reached by scrolling [px]. */
export const LEAST: Size = { width: 236, height: 120 };

/**
 * Plots beside each other while all have room; else one above the other, column by column, on one time axis for each
 * column. The last column's plots share its height where they are fewer.
 */
export function gridOf(plots: number, room: Size, least = LEAST): Grid {
  const abreast = Math.max(1, Math.floor(room.width / least.width));
  const high = Math.max(1, Math.floor(room.height / least.height));
  const columns = Math.max(abreast, Math.ceil(plots / high));
  const rows = Math.max(1, Math.ceil(plots / columns));
  const used = Math.ceil(plots / rows);
  const cells = Array.from({ length: plots }, (_, i): Cell => {
    const [column, row] = [Math.floor(i / rows), i % rows];
    return { column, row, rows: i === plots - 1 ? rows - row : 1 };
  });
  return { rows, columns: used, cells };
}
