import type { Point } from "../../api/types";

const SVG = "http://www.w3.org/2000/svg";
const SHAPES = "path, polyline, polygon, line, rect, circle, ellipse";
const GEOMETRY = ["points", "x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "rx", "ry", "width", "height"];
const MILLIMETRES: Partial<Record<string, number>> = { mm: 1, cm: 10, in: 25.4 };
/** Distance of the points taken from a path [mm]. */
const SPACING = 0.5;
const POINTS_MAX = 4000;
/** Every stroke is laid out by the browser once; a text turned into paths has some hundreds. */
const STROKES_MAX = 2000;

/** The file is no path. */
export class ImportError extends Error {}

/** A flat transform of SVG: x' = a x + c y + e, y' = b x + d y + f. */
export interface Matrix {
  readonly a: number;
  readonly b: number;
  readonly c: number;
  readonly d: number;
  readonly e: number;
  readonly f: number;
}

/** Millimetres per user unit: 1, or what a width in millimetres over its view box says. */
export function unitOf(width: string | null, viewBox: string | null): number {
  const [, length, unit] = /^\s*([\d.]+)\s*(mm|cm|in)\s*$/.exec(width ?? "") ?? [];
  const across = Number((viewBox ?? "").trim().split(/[\s,]+/)[2]); // prettier-ignore
  const scale = (Number(length) * (MILLIMETRES[unit] ?? NaN)) / across;
  return Number.isFinite(scale) && scale > 0 ? scale : 1;
}

/** A point of the drawing, in units whose y goes down, as a point of the plane [m], whose y goes up. */
export function planePoint({ a, b, c, d, e, f }: Matrix, unit: number, x: number, y: number): Point {
  return [(a * x + c * y + e) * unit * 1e-3, -(b * x + d * y + f) * unit * 1e-3];
}

/** The outlines of an SVG file as strokes [m]. Only bare geometry enters the page. Throws ImportError. */
export function parseSvg(text: string): Point[][] {
  const file = new DOMParser().parseFromString(text, "image/svg+xml");
  const root = file.documentElement;
  const fault = file.querySelector("parsererror");
  if (fault) throw new ImportError(`The SVG file is broken: ${faultText(fault)}`);
  if (root.localName !== "svg") throw new ImportError("This is not an SVG file");
  const count = [...root.querySelectorAll(SHAPES)].reduce((sum, shape) => sum + subpathsOf(shape).length, 0);
  if (count > STROKES_MAX)
    throw new ImportError(`The SVG file has ${count} strokes, more than ${STROKES_MAX}`);
  const unit = unitOf(root.getAttribute("width"), root.getAttribute("viewBox"));
  const shapes = [...root.querySelectorAll(SHAPES)].filter((shape) => !shape.closest("defs, clipPath, mask"));
  const strokes = shapes.flatMap((shape) => strokesOf(shape, unit)).filter((points) => points.length > 1);
  if (strokes.length === 0) throw new ImportError("The SVG file has no path");
  return strokes;
}

/** The first line of what the browser says, without the frame that Chromium puts around it. */
function faultText(fault: Element): string {
  return (fault.querySelector("div") ?? fault).textContent.trim().split("\n")[0];
}

/** One stroke per subpath, sampled by the browser itself on copies, which it must have in its page for that. */
function strokesOf(shape: Element, unit: number): Point[][] {
  const matrix = transformOf(shape);
  const stage = document.createElementNS(SVG, "svg");
  stage.style.position = "fixed";
  stage.style.visibility = "hidden";
  stage.append(...copies(shape));
  document.body.append(stage);
  const strokes = [...stage.children].map((copy) => sampled(copy as SVGGeometryElement, matrix, unit));
  stage.remove();
  return strokes;
}

function sampled(copy: SVGGeometryElement, matrix: Matrix, unit: number): Point[] {
  const length = copy.getTotalLength();
  if (length === 0) return [];
  const scale = unit * Math.sqrt(Math.abs(matrix.a * matrix.d - matrix.b * matrix.c));
  const count = Math.min(POINTS_MAX, Math.max(1, Math.ceil((length * scale) / SPACING)));
  return Array.from({ length: count + 1 }, (_, i) => {
    const { x, y } = copy.getPointAtLength((i / count) * length);
    return planePoint(matrix, unit, x, y);
  });
}

/** The data of each subpath; null for the one stroke of a shape that is no path. */
function subpathsOf(shape: Element): (string | null)[] {
  return shape.getAttribute("d")?.split(/(?=M)/) ?? [null];
}

/** The bare geometry, a path's subpaths each by itself. */
function copies(shape: Element): SVGGeometryElement[] {
  return subpathsOf(shape).map((subpath) => {
    const copy = document.createElementNS(SVG, shape.localName) as SVGGeometryElement;
    for (const name of GEOMETRY) {
      const value = shape.getAttribute(name);
      if (value !== null) copy.setAttribute(name, value);
    }
    if (subpath !== null) copy.setAttribute("d", subpath.trim());
    return copy;
  });
}

/** What the shape and the groups around it do to its points. */
function transformOf(shape: Element): DOMMatrix {
  const own = shape instanceof SVGGraphicsElement ? shape.transform.baseVal.consolidate() : null;
  const matrix = own ? DOMMatrix.fromMatrix(own.matrix) : new DOMMatrix();
  const parent = shape.parentElement;
  return parent ? transformOf(parent).multiply(matrix) : matrix;
}
