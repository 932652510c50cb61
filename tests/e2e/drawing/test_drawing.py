"""A drawing's way: drawn, judged, previewed, saved, loaded again, run to its end, and what came of it."""

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, pixels_of, shot, wait_until
from tests.e2e.strokes import LOOP_MM, draw, fact

pytestmark = pytest.mark.keyed(
    "frontend/src", "server/drawing", "controller/reference", "tests/e2e/*.py", imports=False
)
"""How a room of the page works follows the sources of page and room; what moves or stops a rig is always tested."""

AMBER, PINK, VERMILION = (0xE6, 0x9F, 0x00), (0xCC, 0x79, 0xA7), (0xD5, 0x5E, 0x00)


def drawn(page: Page, colour: tuple[int, int, int]) -> int:
    """Pixels of this colour about the loop."""
    (x0, y0), (x1, y1) = (page.evaluate(f"window.__tendril.toPixel({x}, {y})") for x, y in [(140, 140), (260, 80)])
    return len(pixels_of(page, colour, {"x": x0, "y": y0, "width": x1 - x0, "height": y1 - y0}))


def test_a_drawing_is_judged_previewed_saved_loaded_and_run(page: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    page.get_by_test_id("tool-freehand").click()
    draw(page, LOOP_MM)
    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("timing").select_option("duration")
    page.get_by_test_id("duration").fill("3")
    expect(page.get_by_test_id("drawing-reason")).to_contain_text("retimed from 3 s to 3.5")
    wait_until(lambda: fact(page, "Duration").startswith("3.5"))
    assert float(fact(page, "Out of reach").split()[0]) > 5.0
    expect(page.get_by_test_id("drawing-reason")).to_contain_text("out of reach")
    assert drawn(page, VERMILION) > 20, "what is out of reach is red"
    shot(page, "drawing-judged")

    page.get_by_test_id("preview").click()
    expect(page.get_by_test_id("prediction")).to_contain_text("RMSE")
    wait_until(lambda: drawn(page, PINK) > 50)
    shot(page, "drawing-previewed")

    page.get_by_test_id("drawing-name").fill("Loop")
    page.get_by_test_id("save-drawing").click()
    expect(page.get_by_test_id("saved-drawings")).to_contain_text("1")
    page.reload()
    page.get_by_role("tab", name="Run").click()
    page.get_by_text("Drawing", exact=True).click()
    page.get_by_test_id("saved-drawings").click()
    page.get_by_test_id("saved-drawing").filter(has_text="Loop").click()
    wait_until(lambda: fact(page, "Duration").startswith("3.5"))
    assert drawn(page, AMBER) > 50

    page.get_by_test_id("run").click()
    expect(page.get_by_test_id("run-progress")).to_be_visible()
    shot(page, "drawing-runs")
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")
    assert frame(page)["mode"] == Mode.HOLD
    expect(page.get_by_test_id("run-result-facts")).to_contain_text("RMSE")
    expect(page.get_by_test_id("run-recording")).to_be_visible()
    shot(page, "drawing-result")


def test_a_long_preview_comes_bit_by_bit_and_can_be_cancelled(page: Page) -> None:
    page.get_by_test_id("tool-freehand").click()
    draw(page, LOOP_MM)
    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("timing").select_option("duration")
    page.get_by_test_id("duration").fill("280")
    wait_until(lambda: fact(page, "Duration").startswith("280"))
    page.get_by_test_id("preview").click()
    expect(page.get_by_test_id("preview-progress")).to_be_visible()
    wait_until(lambda: drawn(page, PINK) > 0)
    shot(page, "drawing-foreseen-in-part")
    page.get_by_test_id("cancel-preview").click()
    expect(page.get_by_test_id("preview")).to_be_enabled()
    expect(page.get_by_test_id("prediction")).to_be_empty()
    wait_until(lambda: drawn(page, PINK) == 0)

    page.get_by_test_id("duration").fill("10")
    wait_until(lambda: fact(page, "Duration").startswith("10"))
    page.get_by_test_id("preview").click()
    expect(page.get_by_test_id("prediction")).to_contain_text("RMSE")


def test_an_unsaved_drawing_outlives_a_reload_and_a_cleared_one_does_not(
    context: BrowserContext, product: Product
) -> None:
    page = open_page(context, product)
    page.get_by_test_id("tool-freehand").click()
    draw(page, LOOP_MM)
    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("drawing-name").fill("Not saved")
    wait_until(lambda: fact(page, "Length").endswith("mm"))
    length = fact(page, "Length")
    page.reload()
    wait_until(lambda: page.evaluate("!!window.__tendril?.frame") and drawn(page, AMBER) > 50)
    page.get_by_role("tab", name="Run").click()
    expect(page.get_by_test_id("drawing-name")).to_have_value("Not saved")
    wait_until(lambda: fact(page, "Length") == length)
    shot(page, "drawing-reloaded")
    page.get_by_test_id("clear-drawing").click()
    page.reload()
    page.get_by_role("tab", name="Run").click()
    page.get_by_text("Drawing", exact=True).click()
    expect(page.get_by_test_id("drawing-reason")).to_contain_text("Draw on the plan")
