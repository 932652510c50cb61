import type { Point } from "../../api/types";
import { percent } from "../../ui/format";
import { sizeOf } from "./proposal";
import { ImportError, SvgCopy } from "./svgCopy";
import { dataFault, transformFault } from "./svgData";
import { isPainted, isSeen, notesOn } from "./svgSeen";

const SVG = "http://www.w3.org/2000/svg";
/** Millimetres of what a width may be in; px are left out: programs take 72, 90 or 96 of them for an inch. */
const MILLIMETRES: Partial<Record<string, number>> = {
  mm: 1,
  cm: 10,
  q: 0.25,
  in: 25.4,
  pt: 25.4 / 72,
  pc: 25.4 / 6,
};
/** CSS has 96 of them in an inch [mm]. */
export const PIXEL = 25.4 / 96;
/** Points that all strokes of a file get together, and the least of a curve. */
const POINTS = 3000;
const CURVE_POINTS = 16;
/** Every stroke is laid out by the browser once; a text turned into paths has some hundreds. */
const STROKES_MAX = 2000;
const NUMBER = String.raw`([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)`;
/** The move that begins a subpath; its numbers may stand without a blank, as in "M1-2" and "m.5.5". */
const MOVE = new RegExp(String.raw`^([Mm])\s*${NUMBER}[\s,]*${NUMBER}`);
/** Share of the length that may be lost between points before it is said. */
const LOST = 0.005;

/** A flat transform of SVG: x' = a x + c y + e, y' = b x + d y + f. */
export interface Matrix {
  readonly a: number;
  readonly b: number;
  readonly c: number;
  readonly d: number;
  readonly e: number;
  readonly f: number;
}

/** What is seen of an SVG file. */
export interface SvgPath {
  /** In units of the file, y up. */
  readonly strokes: readonly (readonly Point[])[];
  /** Millimetres of a unit, as the page's size says; null where it does not. */
  readonly unit: number | null;
  /** What is left out, a sentence each. */
  readonly notes: readonly string[];
}

/** A stroke as the browser has it. */
interface Laid {
  readonly geometry: SVGGeometryElement;
  readonly matrix: Matrix;
  readonly length: number;
}

/** Millimetres per unit: what width and height say over the view box; null where they are not in a unit of length. */
export function unitOf(attribute: (name: string) => string | null): number | null {
  const [width, height] = [lengthOf(attribute("width")), lengthOf(attribute("height"))];
  const box = attribute("viewBox")?.trim().split(/[\s,]+/).map(Number); // prettier-ignore
  if (!box || box.length !== 4 || !(box[2] > 0 && box[3] > 0)) return (width ?? height) ? PIXEL : null;
  const scales = [width && width / box[2], height && height / box[3]].filter((scale) => scale !== null);
  if (scales.length === 0) return null;
  const ratio = attribute("preserveAspectRatio") ?? "";
  const [least, most] = [Math.min(...scales), Math.max(...scales)];
  if (ratio.trim().startsWith("none") && most > 1.001 * least) return null;
  return ratio.includes("slice") ? most : least;
}

/** A point of the drawing, whose y goes down, as one whose y goes up. */
export function upward({ a, b, c, d, e, f }: Matrix, x: number, y: number): Point {
  return [a * x + c * y + e, -(b * x + d * y + f)];
}

/** The strokes of an SVG file that are seen. Throws ImportError. */
export function parseSvg(text: string): SvgPath {
  const file = new DOMParser().parseFromString(text, "image/svg+xml");
  const root = file.documentElement;
  const fault = file.querySelector("parsererror");
  if (fault) throw new ImportError(`The SVG file is broken: ${faultText(fault)}`);
  if (root.localName !== "svg" || root.namespaceURI !== SVG)
    throw new ImportError(
      `This is not an SVG file: it begins with <${root.localName}>, not with <svg xmlns="${SVG}">`,
    );
  const copy = new SvgCopy(root);
  try {
    const visible = copy.shapes.filter(isSeen);
    requireData(copy, visible);
    const seen = visible.filter((shape) => isPainted(shape, root));
    const laid = seen.flatMap((shape) => laidOut(shape, copy.root));
    const strokes = sampled(laid);
    const notes = [...notesOn(copy, root, seen), ...lost(laid, strokes), ...beyond(copy.root, strokes)];
    if (strokes.length === 0)
      throw new ImportError(["The SVG file has no path that is seen", ...notes].join("; "));
    return { strokes, unit: unitOf((name) => root.getAttribute(name)), notes };
  } finally {
    copy.end();
  }
}

/** The first line of what the browser says, without the frame that Chromium puts around it. */
function faultText(fault: Element): string {
  return (fault.querySelector("div") ?? fault).textContent.trim().split("\n")[0];
}

/** Browsers draw a shape up to the first fault of its data, leave out what they cannot read, and say nothing. */
function requireData(copy: SvgCopy, seen: readonly SVGGeometryElement[]): void {
  for (const shape of seen) {
    const fault = dataFault(shape);
    if (fault !== "") throw new ImportError(`${copy.nameOf(shape)} of the SVG file: ${fault}`);
    if (isRedrawn(shape))
      throw new ImportError(`${copy.nameOf(shape)} of the SVG file: its data is in a style: write it into d`);
  }
  for (const element of copy.drawn.filter((one) => one.hasAttribute("transform"))) {
    const fault = transformFault(element);
    if (fault !== "") throw new ImportError(`${copy.nameOf(element)} of the SVG file: ${fault}`);
  }
  if (getComputedStyle(copy.root).transform !== "none")
    throw new ImportError("The <svg> element itself has a transform: put it on a group in it");
}

/** A style gives a path other data than it has: it is as if it had none, then. */
function isRedrawn(shape: SVGGeometryElement): boolean {
  if (shape.localName !== "path") return false;
  const bare = document.createElementNS(SVG, "path");
  bare.setAttribute("d", shape.getAttribute("d") ?? "");
  return Math.abs(bare.getTotalLength() - shape.getTotalLength()) > 1e-3 * bare.getTotalLength();
}

/** The shape's strokes in the frame of `root`; a path has one for each of its moves. */
function laidOut(shape: SVGGeometryElement, root: SVGSVGElement): Laid[] {
  const [whole, own] = [root.getScreenCTM(), shape.getScreenCTM()];
  if (!whole || !own) return [];
  const matrix = whole.inverse().multiply(own);
  const parts = shape instanceof SVGPathElement ? subpaths(shape) : [shape];
  return parts.map((geometry) => ({ geometry, matrix, length: geometry.getTotalLength() * scaleOf(matrix) }));
}

/** A path for each move of `path`; what comes after one begins where the pen was left. */
function subpaths(path: SVGPathElement): SVGGeometryElement[] {
  const moves = (path.getAttribute("d") ?? "").trim().split(/(?=[Mm])/);
  let pen = { x: 0, y: 0 };
  return moves.map((move) => {
    const part = document.createElementNS(SVG, "path");
    const data = absolute(move, pen);
    if (!data) return part;
    part.setAttribute("d", data.text);
    const length = part.getTotalLength();
    pen = data.closed || length === 0 ? data.start : part.getPointAtLength(length);
    return part;
  });
}

/** The data of one subpath with its move from `pen` made absolute; null where it does not begin with a move. */
export function absolute(move: string, pen: { readonly x: number; readonly y: number }) {
  const found = MOVE.exec(move);
  if (!found) return null;
  const relative = found[1] === "m";
  const [x, y] = [Number(found[2]), Number(found[3])];
  const start = relative ? { x: pen.x + x, y: pen.y + y } : { x, y };
  const rest = move.slice(found[0].length).replace(/^[\s,]+/, "");
  const line = /^[-+.\d]/.test(rest) ? found[1].replace("m", "l").replace("M", "L") : "";
  return { text: `M ${start.x} ${start.y} ${line}${rest}`, start, closed: /z\s*$/i.test(rest) };
}

/** Points along all strokes, evenly; strokes of no length are left out. */
function sampled(strokes: readonly Laid[]): Point[][] {
  const drawn = strokes.filter(({ length }) => length > 0);
  if (drawn.length > STROKES_MAX)
    throw new ImportError(`The SVG file has ${drawn.length} strokes, more than ${STROKES_MAX}`);
  const spacing = drawn.reduce((sum, { length }) => sum + length, 0) / POINTS;
  return drawn.map(({ geometry, matrix, length }) => {
    const least = geometry.localName === "line" ? 1 : CURVE_POINTS;
    const count = Math.max(least, Math.ceil(length / spacing));
    const whole = geometry.getTotalLength();
    return Array.from({ length: count + 1 }, (_, i) => {
      const { x, y } = geometry.getPointAtLength((i / count) * whole);
      return upward(matrix, x, y);
    });
  });
}

/** How much of small turns is lost between the points. */
function lost(laid: readonly Laid[], strokes: readonly (readonly Point[])[]): string[] {
  const whole = laid.reduce((sum, { length }) => sum + length, 0);
  const kept = sizeOf(strokes).length;
  const points = strokes.reduce((sum, stroke) => sum + stroke.length, 0);
  const share = 1 - kept / whole;
  return share > LOST ? [`drawn by ${points} points, which lose ${percent(share, 1)} of the length in small turns`] : []; // prettier-ignore
}

/** How many strokes are not on the page, where its edge is known. */
function beyond(root: SVGSVGElement, strokes: readonly (readonly Point[])[]): string[] {
  const { x, y, width, height } = root.viewBox.baseVal;
  if (width <= 0 || height <= 0) return [];
  const slack = 1e-3 * Math.max(width, height);
  const isOut = ([px, py]: Point) =>
    px < x - slack || px > x + width + slack || -py < y - slack || -py > y + height + slack;
  const count = strokes.filter((stroke) => stroke.some(isOut)).length;
  return count > 0 ? [`strokes that leave the page followed whole: ${count}`] : [];
}

/** Millimetres of "60mm"; null for what is in no unit of length. */
function lengthOf(text: string | null): number | null {
  const match = /^\s*\+?([\d.]+(?:e[-+]?\d+)?)\s*([a-z]+)\s*$/i.exec(text ?? "");
  const length = Number(match?.[1]) * (MILLIMETRES[match?.[2].toLowerCase() ?? ""] ?? NaN);
  return length > 0 ? length : null;
}

function scaleOf({ a, b, c, d }: Matrix): number {
  return Math.sqrt(Math.abs(a * d - b * c));
}
