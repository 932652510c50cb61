"""Several strokes at once: boxed, selected, grouped, turned, undone, saved as pieces, followed and followed again."""

import json
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.strokes import draw, fact

pytestmark = pytest.mark.keyed(
    "frontend/src", "server/drawing", "controller/reference", "tests/e2e/*.py", imports=False
)
"""How a room of the page works follows the sources of page and room; what moves or stops a rig is always tested."""

BARS_MM = [[(x, 125.0), (x, 135.0), (x, 145.0)] for x in (20.0, 35.0, 50.0)]
EMPTY_MM = (100.0, 60.0)
TURN_PX = 10 + 24
"""From the box around what is selected to the disc that turns it: margin and arm of the frame."""


def pixel(page: Page, x: float, y: float) -> tuple[float, float]:
    px, py = page.evaluate(f"window.__tendril.toPixel({x}, {y})")
    return px, py


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    page.mouse.move(*end)
    page.mouse.up()


def pieces(page: Page) -> list[dict[str, Any]]:
    """The drawing's pieces, as the page keeps them over a reload."""
    found: list[dict[str, Any]] = json.loads(page.evaluate("localStorage['tendril-drawing']"))["sketch"]["pieces"]
    return found


def places_mm(page: Page) -> np.ndarray:
    """Middles (n, 2) of the pieces."""
    return 1e3 * np.array([piece["placement"]["centre"] for piece in pieces(page)])


def turns_deg(page: Page) -> np.ndarray:
    return np.degrees([piece["placement"]["angle"] for piece in pieces(page)])


def arm(page: Page) -> None:
    """Take control of the rig in HOLD, where an earlier test may have left it."""
    page.get_by_test_id("lease-take").click()
    if frame(page)["mode"] == Mode.VENTED:
        page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")


def draw_bars(page: Page) -> None:
    page.get_by_test_id("tool-freehand").click()
    for bar in BARS_MM:
        draw(page, bar)


def selected(page: Page, count: int) -> None:
    text = f"{count} selected" if count else "Press pieces, or draw a box"
    expect(page.get_by_test_id("selected")).to_have_text(text)


def test_strokes_are_selected_grouped_turned_and_undone_in_single_steps(page: Page) -> None:
    draw_bars(page)
    page.get_by_test_id("tool-select").click()
    page.mouse.click(*pixel(page, *EMPTY_MM))  # else the last stroke's handles are where the box begins
    drag(page, pixel(page, 2, 112), pixel(page, 40, 128))
    selected(page, 2)
    page.keyboard.down("Shift")
    drag(page, pixel(page, 56, 150), pixel(page, 45, 140))
    page.keyboard.up("Shift")
    selected(page, 3)
    page.mouse.click(*pixel(page, *EMPTY_MM))
    selected(page, 0)
    page.keyboard.press("Control+a")
    selected(page, 3)
    page.keyboard.press("Control+g")
    page.mouse.click(*pixel(page, *EMPTY_MM))
    page.mouse.click(*pixel(page, 35, 135))
    selected(page, 3)
    assert len({piece["group"] for piece in pieces(page)}) == 1

    before = places_mm(page)
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowUp")
    wait_until(lambda: np.allclose(places_mm(page) - before, (1.0, 10.0), atol=0.01))
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    assert places_mm(page) == pytest.approx(before, abs=1e-9)

    middle = (pixel(page, 20, 0)[0] + pixel(page, 50, 0)[0]) / 2
    top, across = pixel(page, 35, 145)[1] - TURN_PX, pixel(page, 35, 135)[1]
    shot(page, "strokes-selected")
    drag(page, (middle, top), (middle - (across - top), across))
    wait_until(lambda: np.allclose(turns_deg(page), 90.0, atol=3.0))
    assert places_mm(page)[:, 0] == pytest.approx(35.0, abs=1.5), "a quarter turn about the middle of the box"
    shot(page, "strokes-turned")
    page.keyboard.press("Control+z")
    assert turns_deg(page) == pytest.approx(0.0)
    page.keyboard.press("Control+Shift+z")
    assert turns_deg(page) == pytest.approx(90.0, abs=3.0)

    page.get_by_test_id("ungroup").click()
    page.mouse.click(*pixel(page, *EMPTY_MM))
    page.mouse.click(*pixel(page, *places_mm(page)[0]))
    selected(page, 1)
    page.get_by_test_id("several").click()
    page.mouse.click(*pixel(page, *places_mm(page)[2]))
    selected(page, 2)
    page.get_by_test_id("plan").focus()
    page.keyboard.press("Delete")
    assert len(pieces(page)) == 1


def test_with_the_select_tool_arrows_leave_the_target_alone(page: Page) -> None:
    arm(page)
    page.get_by_test_id("tool-select").click()
    page.get_by_test_id("plan").focus()
    target = page.evaluate("window.__tendril.handle()")
    for _ in range(5):
        page.keyboard.press("Shift+ArrowUp")
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    assert page.evaluate("window.__tendril.handle()") == target
    page.get_by_test_id("tool-drag").click()
    page.get_by_test_id("plan").focus()
    page.keyboard.press("ArrowUp")
    wait_until(lambda: page.evaluate("window.__tendril.handle()") != target)


def test_saved_strokes_come_back_as_pieces_and_are_followed_again(context: BrowserContext, product: Product) -> None:
    page = open_page(context, product)
    arm(page)
    draw_bars(page)
    page.get_by_test_id("tool-select").click()
    page.get_by_test_id("select-all").click()
    page.get_by_test_id("group").click()
    page.get_by_test_id("turn-left").click()
    kept = pieces(page)
    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("drawing-name").fill("Bars")
    page.get_by_test_id("save-drawing").click()
    expect(page.get_by_test_id("saved-drawings")).to_contain_text("1")
    page.get_by_test_id("clear-drawing").click()
    page.reload()
    page.get_by_role("tab", name="Run").click()
    page.get_by_text("Drawing", exact=True).click()
    page.get_by_test_id("saved-drawings").click()
    page.get_by_test_id("saved-drawing").filter(has_text="Bars").click()
    wait_until(lambda: len(pieces(page)) == 3)
    for piece, before in zip(pieces(page), kept, strict=True):
        assert piece["group"] == before["group"]
        assert piece["placement"]["angle"] == pytest.approx(np.radians(15.0))
        assert np.allclose(piece["shape"], before["shape"], atol=1e-9)
    page.get_by_test_id("tool-select").click()
    page.mouse.click(*pixel(page, *places_mm(page)[0]))
    selected(page, 3)
    wait_until(lambda: fact(page, "Travel").endswith(" s"))
    assert float(fact(page, "Travel").split()[0]) > 0.3
    assert fact(page, "Length") == "60 mm", "without the ways between the strokes"
    expect(page.locator(".legend .key-travel")).to_be_visible()
    shot(page, "strokes-planned")

    def runs() -> list[dict[str, Any]]:
        return page.request.get(f"{product.origin}/api/runs").json()  # type: ignore[no-any-return]

    before = len(runs())  # the card shows the last one of another test, too
    page.get_by_test_id("run").click()
    wait_until(lambda: len(runs()) == before + 1)
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")
    shot(page, "strokes-result")
    page.get_by_test_id("follow-last").click()
    expect(page.get_by_test_id("run-progress")).to_be_visible()
    wait_until(lambda: len(runs()) == before + 2)
    again = runs()[0]
    assert (again["name"], again["state"]) == ("Bars", "done"), again

    expect(page.get_by_test_id("run-sparkline")).to_be_visible()
    assert 64 <= len(again["errors"]) <= 128 and max(again["errors"]) == pytest.approx(again["max_error"], abs=1e-7)
    page.get_by_test_id("clear-trace").click()
    expect(page.get_by_test_id("clear-trace")).to_have_count(0)
    shot(page, "strokes-again")
    page.get_by_test_id("run-compare").click()
    expect(page.get_by_test_id("compare-table").locator("tbody tr")).to_have_count(2)
