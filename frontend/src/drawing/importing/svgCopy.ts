const SVG = "http://www.w3.org/2000/svg";
const XLINK = "http://www.w3.org/1999/xlink";
/** Of elements that are there for the selectors of a style alone, and do nothing. */
const INERT = "about:inert";
const SHAPES: ReadonlySet<string> = new Set(["path", "polyline", "polygon", "line", "rect", "circle", "ellipse"]); // prettier-ignore
/** What is drawn if its parent is. */
const GROUPS: ReadonlySet<string> = new Set(["svg", "g", "a", "switch"]);
const ANIMATIONS = ["animate", "animateColor", "animateMotion", "animateTransform", "set"];
const DROPPED: ReadonlySet<string> = new Set(["script", "style", ...ANIMATIONS]);
/** Their contents are no part of the drawing. */
const EMPTIED: ReadonlySet<string> = new Set(["foreignObject", "image", "text", "metadata"]);
const ELEMENTS_MAX = 20_000;
const HOST = "position: fixed; left: -9999px; top: 0; width: 1000px; height: 1000px; overflow: hidden; contain: strict; pointer-events: none"; // prettier-ignore
/** Marks of the copy: the root, what was <use> and is a <switch> of one, what was <symbol> and is an <svg>. */
const [ROOT, USE, SYMBOL] = ["data-root", "data-use", "data-symbol"];
/** What selects in the copy what these select in the file, with the same weight. */
const SELECTORS: Partial<Record<string, string>> = {
  ":root": `[${ROOT}]`,
  use: `switch:where([${USE}])`,
  symbol: `svg:where([${SYMBOL}])`,
  svg: `svg:where(:not([${SYMBOL}]))`,
};
const SELECTED = /(^|[\s>+~,(])(use|symbol|svg)(?![\w-])|:root(?![\w-])/g;

/** The file is no path. */
export class ImportError extends Error {}

/**
 * A bare copy of the drawing `file`, laid out by the browser where no one sees it, with the file's styles. References
 * are resolved, nothing is loaded, nothing moves and no script enters the page. `end` takes it away.
 */
export class SvgCopy {
  readonly root: SVGSVGElement;
  /** Which element of the file each of the copy is. */
  readonly origins = new Map<Element, Element>();
  private readonly host = document.createElement("div");
  private count = 0;

  constructor(private readonly file: Element) {
    this.root = this.copy(file, []) as SVGSVGElement;
    this.root.setAttribute(ROOT, "");
    fixSize(this.root);
    this.host.style.cssText = HOST;
    const shadow = this.host.attachShadow({ mode: "open" });
    shadow.adoptedStyleSheets = [...file.querySelectorAll("style")].filter(isCss).map(sheetOf);
    shadow.append(this.root);
    document.body.append(this.host);
  }

  /** What is drawn unless a style hides it: shapes, texts and pictures outside of <defs> and its like. */
  get drawn(): SVGGraphicsElement[] {
    const all = [...this.root.querySelectorAll<SVGGraphicsElement>("*")];
    return all.filter((one) => one.namespaceURI === SVG && isDrawn(one.parentElement));
  }

  /** The shapes among `drawn`, in the order in which they are drawn. */
  get shapes(): SVGGeometryElement[] {
    return this.drawn.filter((one) => SHAPES.has(one.localName)) as unknown as SVGGeometryElement[];
  }

  /** How errors call an element of the copy: `<path> 3 (id "outline")`. */
  nameOf(element: Element): string {
    const origin = this.origins.get(element) ?? element;
    const place = [...this.file.querySelectorAll(origin.localName)].indexOf(origin) + 1;
    return `<${origin.localName}> ${place}${origin.id === "" ? "" : ` (id "${origin.id}")`}`;
  }

  end(): void {
    this.host.remove();
  }

  private copy(element: Element, within: readonly Element[]): Element {
    this.count += 1;
    if (this.count > ELEMENTS_MAX)
      throw new ImportError(
        `The SVG file has more than ${ELEMENTS_MAX} elements, references counted as copies`,
      );
    const name = element.localName;
    if (element.namespaceURI !== SVG || DROPPED.has(name)) return this.bare(element, name, INERT);
    if (name === "use") return this.used(element, within);
    const made = this.bare(element, name);
    if (!EMPTIED.has(name)) for (const child of element.children) made.append(this.copy(child, within));
    return made;
  }

  /** What <use> refers to, at its place; a symbol as the picture that it is. */
  private used(use: Element, within: readonly Element[]): Element {
    const id = (use.getAttribute("href") ?? use.getAttributeNS(XLINK, "href") ?? "").trim();
    if (!id.startsWith("#"))
      throw new ImportError(`<use> refers to ${id || "nothing"}, which is not in the file`);
    const target = [...this.file.querySelectorAll("[id]")].find((one) => one.id === id.slice(1));
    if (!target) throw new ImportError(`<use> refers to ${id}, which is not in the file`);
    if (within.includes(target) || target.contains(use))
      throw new ImportError(`<use> of ${id} contains itself`);
    const [outer, inner] = [this.bare(use, "switch"), document.createElementNS(SVG, "switch")];
    outer.setAttribute(USE, "");
    const [x, y] = ["x", "y"].map((name) => use.getAttribute(name) ?? "0");
    inner.style.translate = `${pixels(x)} ${pixels(y)}`;
    inner.append(target.localName === "symbol" ? this.picture(target, use, within) : this.sized(target, use, within)); // prettier-ignore
    outer.append(inner);
    return outer;
  }

  private picture(symbol: Element, use: Element, within: readonly Element[]): Element {
    const made = this.bare(symbol, "svg");
    made.setAttribute(SYMBOL, "");
    for (const side of ["width", "height"]) made.setAttribute(side, use.getAttribute(side) ?? "100%");
    for (const child of symbol.children) made.append(this.copy(child, [...within, symbol]));
    return made;
  }

  /** A copy of `target`; as large as `use` says, if it is a picture of its own. */
  private sized(target: Element, use: Element, within: readonly Element[]): Element {
    const made = this.copy(target, [...within, target]);
    for (const side of target.localName === "svg" ? ["width", "height"] : []) {
      const said = use.getAttribute(side);
      if (said !== null) made.setAttribute(side, said);
    }
    return made;
  }

  private bare(element: Element, name: string, space = SVG): SVGElement {
    const made = document.createElementNS(space, name) as SVGElement;
    this.origins.set(made, element);
    for (const attribute of element.attributes)
      if (isHarmless(attribute))
        made.setAttributeNS(attribute.namespaceURI, attribute.name, withoutLinks(attribute.value));
    const hidden = element.getAttribute("hidden");
    if (space === SVG && hidden !== null && hidden !== "false")
      made.style.setProperty("display", "none", "important");
    return made;
  }
}

/** How many animations there are, which are not followed, and how many styles in other files, which are not read. */
export function unread(file: Element): { readonly animations: number; readonly styles: number } {
  const imports = [...file.querySelectorAll("style")].filter(isCss).map((style) => style.textContent.match(/@import/gi)?.length ?? 0); // prettier-ignore
  const links = file.querySelectorAll('link[rel~="stylesheet"]').length;
  const before = [...file.ownerDocument.childNodes].filter((node) => node.nodeName === "xml-stylesheet").length; // prettier-ignore
  return {
    animations: file.querySelectorAll(ANIMATIONS.join()).length,
    styles: imports.reduce((sum, count) => sum + count, links + before),
  };
}

/** Whether what is in it is drawn, unless a style hides it. */
function isDrawn(parent: Element | null): boolean {
  if (parent === null) return true;
  return parent.namespaceURI === SVG && GROUPS.has(parent.localName) && isDrawn(parent.parentElement);
}

/** Loads nothing, runs nothing and is no mark of the copy. */
function isHarmless({ name, localName }: Attr): boolean {
  return !/^(on.*|href|src|base|is)$/i.test(localName) && ![ROOT, USE, SYMBOL].includes(name) && !/^xmlns(:|$)/.test(name); // prettier-ignore
}

/** One unit of the file is one pixel of the copy, whatever page it asks for. */
function fixSize(root: SVGSVGElement): void {
  const { width, height } = root.viewBox.baseVal;
  if (width <= 0 || height <= 0) return;
  root.setAttribute("width", String(width));
  root.setAttribute("height", String(height));
}

function isCss(style: Element): boolean {
  return ["", "text/css"].includes((style.getAttribute("type") ?? "").trim().toLowerCase());
}

/** Rules of the file; a sheet that is made by hand loads no other one. */
function sheetOf(style: Element): CSSStyleSheet {
  const sheet = new CSSStyleSheet({ media: style.getAttribute("media") ?? "" });
  sheet.replaceSync(withoutLinks(style.textContent));
  selectInCopy(sheet.cssRules);
  return sheet;
}

function selectInCopy(rules: CSSRuleList): void {
  for (const rule of rules) {
    if (rule instanceof CSSStyleRule) rule.selectorText = rule.selectorText.replace(SELECTED, inCopy);
    if ("cssRules" in rule) selectInCopy(rule.cssRules as CSSRuleList);
  }
}

/** What selects in the copy what `selected`, with what parts it from the one before, does in the file. */
function inCopy(selected: string, before = "", name = selected): string {
  return before + (SELECTORS[name] ?? name);
}

/** References to other files are to nothing; what a style calls a namespace is none. */
function withoutLinks(text: string): string {
  const links = /(@namespace[^;]*;)|url\(\s*(?!["']?\s*#)[^)]*\)/gi;
  return text.replace(links, (_, namespace?: string) => namespace ?? "none");
}

function pixels(length: string): string {
  return /^\s*[-+.\d]+(e[-+]?\d+)?\s*$/i.test(length) ? `${length.trim()}px` : length;
}
