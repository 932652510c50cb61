/** What browsers pass over in silence: data of a shape that they draw up to the first fault, or not at all. */

const NUMBER = String.raw`[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?`;
const FIRST = new RegExp(String.raw`\s*${NUMBER}`, "y");
const NEXT = new RegExp(String.raw`\s*,?\s*${NUMBER}`, "y");
const FLAG = /\s*,?\s*[01]/y;
const COMMAND = /\s*([MLHVCSQTAZ])/iy;
const END = /\s*$/y;
const LENGTH = new RegExp(
  String.raw`^\s*(${NUMBER}(px|mm|cm|q|in|pt|pc|r?em|ex|ch|v[wh]|vmin|vmax|%)?|calc\(.*\)|)\s*$`,
  "i",
);
const LENGTHS = ["x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "rx", "ry", "width", "height"];
/** How many numbers each command of a path takes. */
const COUNTS: Partial<Record<string, number>> = {
  M: 2,
  L: 2,
  H: 1,
  V: 1,
  C: 6,
  S: 4,
  Q: 4,
  T: 2,
  A: 7,
  Z: 0,
};
/** Characters of what cannot be read that an error quotes. */
const QUOTED = 20;

/** Reads a text from its beginning on. */
class Reader {
  private at = 0;

  constructor(private readonly text: string) {}

  /** What `pattern` finds here, and goes on behind it; null where that is not here. */
  take(pattern: RegExp): RegExpExecArray | null {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found;
  }

  get fault(): string {
    const rest = this.text.slice(this.at);
    const place = this.at + rest.length - rest.trimStart().length;
    return `from character ${place + 1}${rest.trim() === "" ? ", where it ends," : ` ("${rest.trim().slice(0, QUOTED)}")`} on`;
  }
}

/** Where path data cannot be read; "" where all of it can. */
export function pathFault(data: string): string {
  const reader = new Reader(data);
  for (let first = true; !reader.take(END); first = false) {
    const letter = reader.take(COMMAND)?.[1].toUpperCase() ?? "";
    const count = COUNTS[letter];
    if (count === undefined) return reader.fault;
    if (first && letter !== "M") return `from character 1 on: it begins with ${letter}, not with M`;
    if (count > 0 && !takeNumbers(reader, letter, count)) return reader.fault;
  }
  return "";
}

/** Groups of `count` numbers, one at least; false where one is not whole. */
function takeNumbers(reader: Reader, letter: string, count: number): boolean {
  if (!reader.take(FIRST)) return false;
  for (;;) {
    for (let i = 1; i < count; i++) if (!reader.take(letter === "A" && (i === 3 || i === 4) ? FLAG : NEXT)) return false; // prettier-ignore
    if (!reader.take(NEXT)) return true;
  }
}

/** Where the points of a polygon or polyline cannot be read; "" where all of them can. */
export function pointsFault(points: string): string {
  const reader = new Reader(points);
  let count = 0;
  while (!reader.take(END)) {
    if (!reader.take(count === 0 ? FIRST : NEXT)) return reader.fault;
    count += 1;
  }
  return count % 2 === 0 ? "" : `as they are ${count} numbers: the last x has no y`;
}

/** What of a shape cannot be read; "" where all of it can. */
export function dataFault(shape: SVGGraphicsElement): string {
  const data = pathFault(shape.localName === "path" ? (shape.getAttribute("d") ?? "") : "");
  if (data !== "") return `its data cannot be read ${data}`;
  const points = pointsFault(shape.getAttribute("points") ?? "");
  if (points !== "") return `its points cannot be read ${points}`;
  const wrong = LENGTHS.find((name) => !LENGTH.test(shape.getAttribute(name) ?? ""));
  return wrong === undefined ? "" : `${wrong} = "${shape.getAttribute(wrong) ?? ""}" is no length`;
}

/** What of the transform of an element cannot be read; "" where all of it can. */
export function transformFault(element: SVGGraphicsElement): string {
  const said = element.getAttribute("transform") ?? "";
  const parts = said.trim() === "none" ? 0 : said.split(/[()]/).filter((part) => part.trim().replace(/,/g, "") !== "").length; // prettier-ignore
  return parts === 2 * element.transform.baseVal.numberOfItems ? "" : `transform = "${said}" cannot be read`;
}
