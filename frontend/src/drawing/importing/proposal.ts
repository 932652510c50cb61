import { api, asCsv, dataOf } from "../../api/rest";
import type { ImportChoices, ImportProposal, Point, ProposedColumn } from "../../api/types";
import { distance } from "../piece";

export type Meaning = "t" | "x" | "y";
export const LENGTHS = ["m", "cm", "mm", "um", "in"] as const;
export const TIMES = ["s", "ms", "us", "ns"] as const;
export type LengthUnit = (typeof LENGTHS)[number];
export type TimeUnit = (typeof TIMES)[number];

const NAME_MAX = 80;
/** Longest name of a file that the server takes. */
const FILE_NAME_MAX = 255;

/** How the server would read `file`, of which it keeps nothing. Raises Refusal for what is no table. */
export function propose(file: File, choices: ImportChoices): Promise<ImportProposal> {
  const query = { ...choices, name: file.name.slice(-FILE_NAME_MAX) };
  return dataOf(api.POST("/api/drawings/import/proposal", { params: { query }, ...asCsv(file) }));
}

/** Take column `index` as `name`, or as none; each name belongs to one column. Numbers count from 1, 0 is none. */
export function assigned(
  columns: readonly Pick<ProposedColumn, "name">[],
  index: number,
  name: Meaning | null,
): Record<Meaning, number> {
  const names = columns.map((column, i) => (i === index ? name : column.name === name ? null : column.name));
  const numberOf = (meaning: Meaning) => names.indexOf(meaning) + 1;
  return { t: numberOf("t"), x: numberOf("x"), y: numberOf("y") };
}

/** The columns as they were chosen, before the server has read the file so. */
export function chosen(columns: readonly ProposedColumn[], choices: ImportChoices): ProposedColumn[] {
  const { t, x, y } = choices;
  return columns.map((column, i) => {
    const place = ([["t", t], ["x", x], ["y", y]] as const).find(([, number]) => number === i + 1)?.[0] ?? null; // prettier-ignore
    const name = x == null ? column.name : place;
    if (column.stated && name === column.name) return column;
    const unit = name === "t" ? choices.time_unit : choices.length_unit;
    return { ...column, name, stated: false, unit: name === null ? null : (unit ?? null) };
  });
}

/** What must be said before the file is imported; "" when nothing is left open. */
export function openQuestion(columns: readonly ProposedColumn[]): string {
  const named = (name: Meaning) => columns.find((column) => column.name === name);
  const missing = (["x", "y"] as const).filter((name) => !named(name));
  if (missing.length > 0) return `Say which column is ${missing.join(" and which is ")}`;
  if (named("x")?.unit == null || named("y")?.unit == null)
    return "Say in which unit x and y are: the file does not";
  const time = named("t");
  return time && time.unit === null ? "Say in which unit t is: the file does not" : "";
}

/** A name that the server takes for a drawing, from the name of a file. */
export function nameOf(file: string): string {
  const plain = file.normalize("NFKD").replace(/\p{M}/gu, "");
  const stem = plain.replace(/\.[^.]*$/, "") || plain;
  const spelled = stem.replace(/[^A-Za-z0-9_ .-]+/g, "-").replace(/^[^A-Za-z0-9_]+/, "");
  return spelled.slice(0, NAME_MAX).replace(/(\.csv|\s)+$/i, "");
}

/** Length along all strokes, the way from one to the next left out; width and height [m]. */
export function sizeOf(strokes: readonly (readonly Point[])[]) {
  const along = (points: readonly Point[]) =>
    points.reduce((sum, point, i) => sum + (i > 0 ? distance(points[i - 1], point) : 0), 0);
  const { left, right, bottom, top } = boxOf(strokes);
  return {
    length: strokes.reduce((sum, stroke) => sum + along(stroke), 0),
    width: right - left,
    height: top - bottom,
  };
}

/** What the strokes fill [m]. */
export function boxOf(strokes: readonly (readonly Point[])[]) {
  const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (const stroke of strokes)
    for (const [x, y] of stroke) {
      box.left = Math.min(box.left, x);
      box.right = Math.max(box.right, x);
      box.bottom = Math.min(box.bottom, y);
      box.top = Math.max(box.top, y);
    }
  return box;
}
