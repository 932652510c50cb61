"""The page's edge with state and E-STOP: whether it is in reach, and really pressed."""

import json
import time
from typing import Any

from playwright.sync_api import Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, wait_until

SIZES = [(w, h) for one, other in ((320, 568), (390, 844), (700, 1000), (820, 1180), (1280, 720)) for w, h in
         ((one, other), (other, one))]  # fmt: skip
"""Portrait and landscape [CSS px]."""
ZOOMED = {200: (640, 360), 300: (427, 240), 400: (320, 180)}
"""What a zoom [%] leaves of a screen of 1280 x 720 [CSS px]."""
TROUBLES = """() => {
  const troubles = [], seen = window.visualViewport, round = ({ left, top, right, bottom }) =>
    [left, top, right, bottom].map(Math.round).join(" ");
  const box = (id) => document.querySelector(`[data-testid=${id}]`).getBoundingClientRect();
  const clipped = (element, x, y) => {
    for (let at = element.parentElement; at && at !== document.body; at = at.parentElement) {
      const { left, top, right, bottom } = at.getBoundingClientRect();
      const hides = getComputedStyle(at).overflowX !== "visible";
      if (hides && (x < left || x > right || y < top || y > bottom)) return true;
    }
    return false;
  };
  for (const id of ["e-stop", "state"]) {
    const { left, top, right, bottom } = box(id), name = `${id} at ${round(box(id))}`;
    const [x0, y0] = [seen.offsetLeft - 0.5, seen.offsetTop - 0.5];
    if (left < x0 || right > x0 + seen.width + 1) troubles.push(`${name}: beside what is seen`);
    if (top < y0 || bottom > y0 + seen.height + 1) troubles.push(`${name}: above or below what is seen`);
    const inset = 4 / seen.scale, middle = [(left + right) / 2, (top + bottom) / 2];
    const corners = [left + inset, right - inset].flatMap((x) => [top + inset, bottom - inset].map((y) => [x, y]));
    for (const [x, y] of id === "state" ? [middle] : [middle, ...corners]) {
      const hit = document.elementFromPoint(x, y);
      if (!hit?.closest(`[data-testid=${id}]`)) troubles.push(`${name}: covered by ${hit?.outerHTML.slice(0, 120)}`);
    }
  }
  const { width, height } = box("e-stop");
  if (Math.min(width, height) * seen.scale < 40) troubles.push(`e-stop of ${width} x ${height} px: too small`);
  const bar = document.querySelector(".stop-bar").getBoundingClientRect();
  for (const element of document.querySelectorAll("#root :is(button, input, select, a, [role=tab])")) {
    const { left, top, right, bottom, width } = element.getBoundingClientRect();
    const [x, y] = [(left + right) / 2, (top + bottom) / 2];
    const under = width > 1 && x >= bar.left && x <= bar.right && y >= bar.top && y <= bar.bottom;
    if (under && !clipped(element, x, y)) troubles.push(`the bar covers ${element.outerHTML.slice(0, 120)}`);
  }
  return troubles;
}"""
"""What keeps a hand from state and E-STOP, or what they keep it from."""
REACHED = """(id) => {
  const element = document.querySelector(`[data-testid=${id}]`);
  element.scrollIntoView({ block: "nearest", inline: "nearest" });
  const { left, top, right, bottom } = element.getBoundingClientRect();
  const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  return element.contains(hit) ? "" : `${id} lies under ${hit?.outerHTML.slice(0, 120)}`;
}"""
APART = """([one, other]) => {
  const [a, b] = [one, other].map((selector) => document.querySelector(selector).getBoundingClientRect());
  return a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
}"""
ASK = """async ([method, path, body]) => {
  const answer = await fetch(path, { method, body, headers: body ? { "content-type": "application/json" } : {} });
  return answer.ok;
}"""


def troubles(page: Page, where: str) -> list[str]:
    """What is wrong with the edge of the page as it is now, one line each."""
    return [f"{where}: {trouble}" for trouble in page.evaluate(TROUBLES)]


def ask(page: Page, method: str, path: str, **body: Any) -> bool:
    """Have the page's own session ask the server."""
    return bool(page.evaluate(ASK, [method, path, json.dumps(body) if body else None]))


def press(page: Page, product: Product, *, touch: bool, where: str) -> None:
    """Press where the button is seen; the rig stops, and the page says by which way it was told."""
    box = page.evaluate("""() => {
      const { left, top, right, bottom } = document.querySelector("[data-testid=e-stop]").getBoundingClientRect();
      const { offsetLeft, offsetTop } = window.visualViewport; // where the driver counts from
      return [(left + right) / 2 - offsetLeft, (top + bottom) / 2 - offsetTop];
    }""")
    (page.touchscreen.tap if touch else page.mouse.click)(*box)
    expect(page.get_by_test_id("stop-news"), where).to_contain_text("E-STOP arrived at the rig")
    assert product.mode() == Mode.E_STOP, where
    expect(page.get_by_test_id("state"), where).to_contain_text("E-STOP")


def escape_twice(page: Page) -> None:
    """Esc, Esc, within 1 s: again where a busy machine took longer, as they are then no stop."""
    for _ in range(20):
        begin = time.monotonic()
        page.keyboard.press("Escape")
        page.keyboard.press("Escape")
        if time.monotonic() - begin < 0.9:
            return


def clear(page: Page, product: Product) -> None:
    """Out of the latch again, by the page's session, which operates."""
    wait_until(lambda: ask(page, "POST", "/api/command", request="clear") and product.mode() == Mode.VENTED)
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
