import { unread, type SvgCopy } from "./svgCopy";

/** Neither it nor a group around it is put away, hidden or clear; no <switch> or condition leaves it out. */
export function isSeen(element: Element): boolean {
  return (
    getComputedStyle(element).visibility === "visible" && element.checkVisibility() && isRendered(element)
  );
}

/** Browsers do not ask the groups for this (`checkVisibility`). */
function isRendered(element: Element): boolean {
  const { display, opacity } = getComputedStyle(element);
  if (display === "none" || parseFloat(opacity) === 0) return false;
  return element.parentElement === null || isRendered(element.parentElement);
}

/** It has a colour and a place for it, given the file's gradients. */
export function isPainted(shape: SVGGeometryElement, file: Element): boolean {
  const { fill, fillOpacity, stroke, strokeOpacity, strokeWidth } = getComputedStyle(shape);
  if (["rect", "ellipse"].includes(shape.localName) && isFlat(shape.getBBox())) return false;
  if (shape.localName !== "line" && paints(fill, fillOpacity, file)) return true;
  return paints(stroke, strokeOpacity, file) && parseFloat(strokeWidth) > 0;
}

/** Browsers draw no rectangle and no ellipse without width or height, not even its outline. */
function isFlat({ width, height }: DOMRect): boolean {
  return width === 0 || height === 0;
}

function paints(colour: string, opacity: string, file: Element): boolean {
  const reference = /^url\("?#(.*?)"?\)\s*(.*)$/.exec(colour);
  if (reference) {
    const known = [...file.querySelectorAll("[id]")].some((one) => one.id === reference[1]);
    return known ? parseFloat(opacity) > 0 : paints(reference[2] || "none", opacity, file);
  }
  return colour !== "none" && !/^rgba\(.*, 0\)$|\/ 0%?\)$/.test(colour) && parseFloat(opacity) > 0;
}

/** What is left out, or followed otherwise than it is seen, a sentence each. */
export function notesOn(copy: SvgCopy, file: Element, seen: readonly SVGGeometryElement[]): string[] {
  const shown = copy.drawn.filter(isSeen);
  const named = (...names: string[]) => shown.filter(({ localName }) => names.includes(localName)).length;
  const { animations, styles } = unread(file);
  const notes: readonly (readonly [number, string])[] = [
    [copy.shapes.length - seen.length, "hidden or unpainted shapes left out"],
    [named("text"), "texts left out, which are no paths yet"],
    [named("image", "foreignObject"), "pictures left out"],
    [seen.filter(hasMarkers).length, "shapes whose arrow heads or other markers are left out"],
    [shown.filter(isCut).length, "clipped or masked parts followed whole"],
    [shown.filter(isFiltered).length, "parts followed as they are without their filter"],
    [animations, "animations left out"],
    [styles, "styles in other files not read, which may hide parts"],
  ];
  return notes.filter(([count]) => count > 0).map(([count, what]) => `${what}: ${count}`);
}

function hasMarkers(shape: SVGGeometryElement): boolean {
  const { markerStart, markerMid, markerEnd } = getComputedStyle(shape);
  return [markerStart, markerMid, markerEnd].some((marker) => marker !== "none");
}

/** It has a clip or a mask, or is a picture in the picture that cuts what it holds. */
function isCut(element: SVGGraphicsElement): boolean {
  const { clipPath, maskImage, overflow } = getComputedStyle(element);
  const cuts = element instanceof SVGSVGElement && element.ownerSVGElement !== null && overflow !== "visible";
  return clipPath !== "none" || maskImage !== "none" || (cuts && reachesOut(element));
}

/** Whether what `picture` holds leaves its own box. */
function reachesOut(picture: SVGSVGElement): boolean {
  const box = picture.viewBox.baseVal;
  const { width, height } = box.width > 0 ? box : { width: picture.width.baseVal.value, height: picture.height.baseVal.value }; // prettier-ignore
  const [x, y] = box.width > 0 ? [box.x, box.y] : [0, 0];
  const own = picture.getScreenCTM();
  if (!own) return false;
  const slack = 1e-3 * Math.max(width, height);
  return [
    ...picture.querySelectorAll<SVGGeometryElement>("path, polyline, polygon, line, rect, circle, ellipse"),
  ].some((shape) => {
    const matrix = shape.getScreenCTM();
    if (!matrix || !isSeen(shape)) return false;
    const { left, right, top, bottom } = boxIn(own.inverse().multiply(matrix), shape.getBBox());
    return left < x - slack || right > x + width + slack || top < y - slack || bottom > y + height + slack;
  });
}

function boxIn(matrix: DOMMatrix, { x, y, width, height }: DOMRect) {
  const corners = [[x, y], [x + width, y], [x, y + height], [x + width, y + height]].map(([px, py]) => new DOMPoint(px, py).matrixTransform(matrix)); // prettier-ignore
  const [xs, ys] = [corners.map((one) => one.x), corners.map((one) => one.y)];
  return { left: Math.min(...xs), right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
}

function isFiltered(element: Element): boolean {
  return getComputedStyle(element).filter !== "none";
}
