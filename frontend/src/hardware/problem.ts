/** What is wrong with a rig file, taken apart so that it can be shown beside the line that it is about. */
export interface Problem {
  /** As "valves.pressure_max"; "" where it concerns no field. */
  readonly field: string;
  readonly value: string;
  /** What the value must keep, or what is wrong at all. */
  readonly bound: string;
  /** Line of the text, from 1; null where it is not known. */
  readonly line: number | null;
}

const FIELD = "[A-Za-z_][\\w.]*";
const OF_FIELD = new RegExp(`^(${FIELD}) = (.*?): (.*)$`, "s");
/** What a table as a whole must keep: "valves: chambers = [0, 1, 1, 2] names a channel twice". */
const OF_TABLE = new RegExp(`^(${FIELD}): (${FIELD}) = (\\[.*?\\]|\\S+) (.*)$`, "s");
const PLACE = / ?\(at line (\d+), column \d+\)/;

/** The server's sentence about `text`, taken apart. */
export function problemOf(said: string, text: string): Problem {
  const place = PLACE.exec(said);
  if (place) return { field: "", value: "", bound: said.replace(PLACE, ""), line: Number(place[1]) };
  if (said.endsWith("(at end of document)"))
    return { field: "", value: "", bound: said, line: text.trimEnd().split("\n").length };
  const body = said.replace(/^\S+\.toml: /, "");
  const [, table = "", inner = "", of = "", what = ""] = OF_TABLE.exec(body) ?? [];
  if (table !== "") {
    const field = `${table}.${inner}`;
    return { field, value: of, bound: what, line: lineOf(field, text) };
  }
  const [, field = "", value = "", bound = ""] = OF_FIELD.exec(body) ?? [];
  if (field === "") return { field: "", value: "", bound: body, line: null };
  return { field, value, bound: inWords(bound), line: lineOf(field, text) };
}

function inWords(bound: string): string {
  return bound
    .replace(/^(Input|String|List|Tuple|Value|Dictionary) should /, "must ")
    .replace(/^Extra inputs are not permitted$/, "there is no such field");
}

/** The line on which `text` gives `field` a value, else that of its nearest table; null where there is neither. */
export function lineOf(field: string, text: string): number | null {
  const wanted = field.split(".");
  let table: string[] = [];
  let best: { line: number; depth: number } | null = null;
  for (const [i, line] of text.split("\n").entries()) {
    const head = /^\s*\[\[?\s*([\w.-]+)\s*\]/.exec(line);
    const key = head ? null : /^\s*([\w.-]+)\s*=/.exec(line);
    if (head) table = head[1].split(".");
    const here = head ? table : key ? [...table, ...key[1].split(".")] : [];
    if (here.length === 0 || here.some((part, depth) => wanted[depth] !== part)) continue;
    if (here.length > (best?.depth ?? 0)) best = { line: i + 1, depth: here.length };
  }
  return best?.line ?? lineOfKey(wanted.at(-1) ?? "", text);
}

/** The only line that gives a key of this name a value: some refusals leave out the table. */
function lineOfKey(name: string, text: string): number | null {
  const lines = text.split("\n");
  const found = lines.flatMap((line, i) => (line.trimStart().split(/\s*=/)[0] === name ? [i + 1] : []));
  return found.length === 1 ? (found[0] ?? null) : null;
}
