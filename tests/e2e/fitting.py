"""Whether all text of a part of the page has its room: what is wrong, one line each."""

from playwright.sync_api import Page

MISFITS = """(selector) => {
  const root = document.querySelector(selector), misfits = [], placed = [];
  const name = (element) => `${element.tagName.toLowerCase()}.${element.className} "${text(element).slice(0, 24)}"`;
  const text = (element) => (element.value ?? element.textContent).trim();
  const style = (element) => getComputedStyle(element);
  const around = (element) => {
    const all = [];
    for (let at = element; at && at !== document.body; at = at.parentElement) all.push(at);
    return all;
  };
  const isText = (node) => node.nodeType === Node.TEXT_NODE && node.data.trim() !== "";
  const own = (element) => [...element.childNodes].filter(isText);
  const spread = (nodes) => {
    const range = document.createRange();
    range.setStartBefore(nodes[0]);
    range.setEndAfter(nodes.at(-1));
    return range.getBoundingClientRect();
  };
  const page = document.scrollingElement;
  if (page.scrollWidth > page.clientWidth) misfits.push(`the page is ${page.scrollWidth} px wide`);
  if (root.scrollWidth > root.clientWidth) misfits.push(`it is ${root.scrollWidth} px wide`);
  for (const element of root.querySelectorAll("*")) {
    const field = ["INPUT", "TEXTAREA"].includes(element.tagName);
    const said = element.closest(".sr-only, .mantine-VisuallyHidden-root, style") || style(element).clipPath !== "none";
    const unseen = said || !element.checkVisibility();
    if (unseen || (!field && own(element).length === 0)) continue;
    const box = field ? element.getBoundingClientRect() : spread(own(element));
    const seen = { left: box.left, top: box.top, right: box.right, bottom: box.bottom };
    let dots = false, scrolls = false;
    for (const at of around(element)) {
      const { overflowX, overflowY, textOverflow, webkitLineClamp } = style(at);
      const { left, top, right, bottom } = at.getBoundingClientRect();
      dots ||= textOverflow === "ellipsis" || webkitLineClamp !== "none";
      scrolls ||= overflowX !== "hidden" && at.scrollWidth > at.clientWidth && overflowX !== "visible";
      if (overflowX !== "visible") {
        if (seen.left < right && seen.right > right + 1 && !dots && !scrolls && !field)
          misfits.push(`${name(element)} is cut off by ${name(at)}`);
        [seen.left, seen.right] = [Math.max(seen.left, left), Math.min(seen.right, right)];
      }
      if (overflowY !== "visible") [seen.top, seen.bottom] = [Math.max(seen.top, top), Math.min(seen.bottom, bottom)];
    }
    if (!scrolls && seen.left < seen.right && seen.top < seen.bottom && seen.right > innerWidth + 1)
      misfits.push(`${name(element)} is pushed out of the page`);
    const short = element.clientWidth > 0 && element.scrollWidth > element.clientWidth; // of what CSS adds, too
    const cut = !field && !scrolls && (box.right > seen.right + 1 || short);
    const titles = around(element).map((at) => at.title).filter((title) => title !== undefined && title !== "");
    const known = titles.some((title) => title.includes(text(element).replace(/^(#|▲ )/, "")));
    if (cut && dots && !known) misfits.push(`${name(element)} is cut, and nothing says the rest`);
    if (seen.right - seen.left > 1 && seen.bottom - seen.top > 1) placed.push([element, seen]);
  }
  for (const [i, [one, a]] of placed.entries())
    for (const [other, b] of placed.slice(i + 1)) {
      const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2 &&
        Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
      const within = one.contains(other) || other.contains(one) || one.closest("th") || other.closest("th");
      if (over && !within) misfits.push(`${name(one)} lies over ${name(other)}`);
    }
  return misfits.slice(0, 20);
}"""
"""Text that is pushed out, cut without dots, cut without a title that has all of it, or under other text."""
COLUMNS = """(selector) => {
  const edges = {};
  for (const cell of document.querySelectorAll(`${selector} tbody tr > *`)) {
    const { left, right } = cell.getBoundingClientRect();
    if (right > left) (edges[cell.className] ??= new Set()).add(`${Math.round(left)} ${Math.round(right)}`);
  }
  return Object.entries(edges).filter(([, found]) => found.size > 1).map(([column]) => column);
}"""
"""Columns of a table whose cells are not one below the other."""


def misfits(page: Page, selector: str) -> list[str]:
    """What of the part `selector` has no room at the page's size now."""
    return [f"{page.viewport_size}, {selector}: {misfit}" for misfit in page.evaluate(MISFITS, selector)]


def crooked(page: Page, selector: str) -> list[str]:
    """Columns of the table `selector` that are not straight."""
    return [f"{page.viewport_size}: {column} is not straight" for column in page.evaluate(COLUMNS, selector)]
