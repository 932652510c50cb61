import type { Point } from "../../api/types";

/** A path read from a file [m], with times [s] where the file has them. */
export interface Imported {
  readonly points: readonly Point[];
  readonly times: readonly number[] | null;
}

/** The file is no path. */
export class ImportError extends Error {}

/** Values beyond this are millimetres where the header does not say: the plane ends at 2 m. */
const METRES_MAX = 2;

/** Read "x,y" or "t,x,y" rows; a header may name the unit of each column, as "x [mm]". Throws ImportError. */
export function parseCsv(text: string): Imported {
  const lines = text.split(/\r?\n/).map(cellsOf).filter((cells) => cells.length > 0); // prettier-ignore
  const header =
    lines.at(0)?.every((cell) => Number.isFinite(Number(cell))) === false ? lines.shift() : undefined;
  const rows = lines.map((cells, i) => numbersOf(cells, i + 1));
  if (rows.length < 2) throw new ImportError("A path needs at least two rows of numbers");
  const columns = rows[0].length;
  if (columns !== 2 && columns !== 3)
    throw new ImportError(`Rows have ${columns} columns instead of x, y or t, x, y`);
  if (rows.some((row) => row.length !== columns)) throw new ImportError("Rows are not equally long");
  const scale = scaleOf(header, rows);
  const points = rows.map((row): Point => [row[columns - 2] * scale, row[columns - 1] * scale]);
  return { points, times: columns === 3 ? timesOf(rows) : null };
}

function cellsOf(line: string): string[] {
  const text = line.trim();
  return text === "" || text.startsWith("#") ? [] : text.split(/\s*[,;\t]\s*|\s+(?=[-+.\d])/);
}

function numbersOf(cells: readonly string[], row: number): number[] {
  const values = cells.map(Number);
  const wrong = cells.find((_, i) => !Number.isFinite(values[i]));
  if (wrong !== undefined) throw new ImportError(`Row ${row}: "${wrong}" is not a number`);
  return values;
}

/** Metres per unit of the file. */
function scaleOf(header: readonly string[] | undefined, rows: readonly (readonly number[])[]): number {
  const unit = /\b(mm|cm|m)\b/.exec(header?.at(-1) ?? "")?.[1];
  if (unit === "mm") return 1e-3;
  if (unit === "cm") return 1e-2;
  if (unit === "m") return 1;
  const far = rows.some((row) => row.slice(-2).some((value) => Math.abs(value) > METRES_MAX));
  return far ? 1e-3 : 1;
}

function timesOf(rows: readonly (readonly number[])[]): number[] {
  const times = rows.map(([t]) => t - rows[0][0]);
  if (times.some((t, i) => i > 0 && t <= times[i - 1]))
    throw new ImportError("Times do not rise from row to row");
  return times;
}
