const SVG = "http://www.w3.org/2000/svg";
const XLINK = "http://www.w3.org/1999/xlink";
const SHAPES: ReadonlySet<string> = new Set(["path", "polyline", "polygon", "line", "rect", "circle", "ellipse"]); // prettier-ignore
const GROUPS: ReadonlySet<string> = new Set(["svg", "g", "a", "switch"]);
/** What a file may say about where its shapes lie, how large they are and whether they are seen. */
const GEOMETRY = [
  "d",
  "points",
  "x",
  "y",
  "x1",
  "y1",
  "x2",
  "y2",
  "cx",
  "cy",
  "r",
  "rx",
  "ry",
  "width",
  "height",
];
const LOOKS = ["transform", "transform-origin", "viewBox", "preserveAspectRatio", "class", "id", "style"];
const PAINT = ["display", "visibility", "opacity", "fill", "fill-opacity", "stroke", "stroke-opacity", "stroke-width"]; // prettier-ignore
const KEPT = [...GEOMETRY, ...LOOKS, ...PAINT, "systemLanguage"];
const ELEMENTS_MAX = 20_000;
const HOST = "position: fixed; left: -9999px; top: 0; width: 1000px; height: 1000px; overflow: hidden; contain: strict; pointer-events: none"; // prettier-ignore

/** The file is no path. */
export class ImportError extends Error {}

/** Elements that are followed by their outline alone, or not at all, and how many there are. */
export interface Left {
  texts: number;
  pictures: number;
  clipped: number;
}

/**
 * A bare copy of the drawing `file`, laid out by the browser where nobody sees it: shapes and groups with what places,
 * sizes and hides them. References are resolved, nothing is loaded and no script enters the page. `end` takes it away.
 */
export class SvgCopy {
  readonly root: SVGSVGElement;
  readonly left: Left = { texts: 0, pictures: 0, clipped: 0 };
  private readonly host = document.createElement("div");
  private count = 0;

  constructor(private readonly file: Element) {
    this.root = this.copy(file, []) as SVGSVGElement;
    fixSize(this.root);
    this.host.style.cssText = HOST;
    const shadow = this.host.attachShadow({ mode: "open" });
    shadow.adoptedStyleSheets = [...file.querySelectorAll("style")].map(sheetOf);
    shadow.append(this.root);
    document.body.append(this.host);
  }

  /** The shapes, in the order in which they are drawn. */
  get shapes(): SVGGeometryElement[] {
    return [...this.root.querySelectorAll<SVGGeometryElement>([...SHAPES].join())];
  }

  end(): void {
    this.host.remove();
  }

  private copy(element: Element, within: readonly Element[]): Element | null {
    this.count += 1;
    if (this.count > ELEMENTS_MAX)
      throw new ImportError(
        `The SVG file has more than ${ELEMENTS_MAX} elements, references counted as copies`,
      );
    if (element.localName === "use") return this.used(element, within);
    if (element.localName === "text") this.left.texts += 1;
    if (element.localName === "image" || element.localName === "foreignObject") this.left.pictures += 1;
    if (!SHAPES.has(element.localName) && !GROUPS.has(element.localName)) return null;
    const made = this.bare(element, element.localName);
    for (const child of element.children) {
      const copied = this.copy(child, within);
      if (copied) made.append(copied);
    }
    return made;
  }

  /** What <use> refers to, at its place; a symbol as the picture that it is. */
  private used(use: Element, within: readonly Element[]): Element | null {
    const id = (use.getAttribute("href") ?? use.getAttributeNS(XLINK, "href") ?? "").trim();
    if (!id.startsWith("#"))
      throw new ImportError(`<use> refers to ${id || "nothing"}, which is not in the file`);
    const target = [...this.file.querySelectorAll("[id]")].find((one) => one.id === id.slice(1));
    if (!target) throw new ImportError(`<use> refers to ${id}, which is not in the file`);
    if (within.includes(target) || target.contains(use))
      throw new ImportError(`<use> of ${id} contains itself`);
    const [outer, inner] = [this.bare(use, "g"), document.createElementNS(SVG, "g")];
    const [x, y] = ["x", "y"].map((name) => use.getAttribute(name) ?? "0");
    inner.style.translate = `${pixels(x)} ${pixels(y)}`;
    const copied = target.localName === "symbol" ? this.picture(target, use, within) : this.copy(target, [...within, target]); // prettier-ignore
    if (copied) inner.append(copied);
    outer.append(inner);
    return outer;
  }

  private picture(symbol: Element, use: Element, within: readonly Element[]): Element {
    const made = this.bare(symbol, "svg");
    for (const side of ["width", "height"]) made.setAttribute(side, use.getAttribute(side) ?? "100%");
    for (const child of symbol.children) {
      const copied = this.copy(child, [...within, symbol]);
      if (copied) made.append(copied);
    }
    return made;
  }

  private bare(element: Element, name: string): SVGElement {
    const made = document.createElementNS(SVG, name);
    for (const attribute of KEPT) {
      const value = element.getAttribute(attribute);
      const placed = name === "g" && (attribute === "x" || attribute === "y");
      if (value !== null && !placed) made.setAttribute(attribute, withoutLinks(value));
    }
    const hidden = element.getAttribute("hidden");
    if (hidden !== null && hidden !== "false") made.style.setProperty("display", "none", "important");
    if (element.hasAttribute("clip-path") || element.hasAttribute("mask")) this.left.clipped += 1;
    return made;
  }
}

/** One unit of the file is one pixel of the copy, whatever page it asks for. */
function fixSize(root: SVGSVGElement): void {
  const { width, height } = root.viewBox.baseVal;
  if (width <= 0 || height <= 0) return;
  root.setAttribute("width", String(width));
  root.setAttribute("height", String(height));
}

/** Rules of the file; a sheet that is made by hand loads no other one. */
function sheetOf(style: Element): CSSStyleSheet {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(withoutLinks(style.textContent));
  return sheet;
}

/** A colour of some kind for every reference: a gradient paints, a clip is told apart before. */
function withoutLinks(text: string): string {
  return text.replace(/url\([^)]*\)/gi, "black");
}

function pixels(length: string): string {
  return /^\s*[-+.\d]+(e[-+]?\d+)?\s*$/i.test(length) ? `${length.trim()}px` : length;
}
