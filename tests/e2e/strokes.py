"""A mouse that draws on the plan, and what the page says about the drawing."""

import math

from playwright.sync_api import Page

LOOP_MM = [(200.0 - 45.0 * math.cos(s / 6), 110.0 + 25.0 * math.sin(s / 6)) for s in range(38)]
"""Once round; its right end is out of reach."""


def draw(page: Page, points_mm: list[tuple[float, float]]) -> None:
    """One stroke of the mouse."""
    pixels = [page.evaluate(f"window.__tendril.toPixel({x}, {y})") for x, y in points_mm]
    page.mouse.move(*pixels[0])
    page.mouse.down()
    for pixel in pixels[1:]:
        page.mouse.move(*pixel)
    page.mouse.up()


def fact(page: Page, name: str) -> str:
    """What the panel says about the drawing under this name."""
    return page.locator(f"[data-testid=drawing-facts] div:has(dt:text-is('{name}')) dd").inner_text()
