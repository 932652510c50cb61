"""The reference menu: what is chosen there is drawn on the plan, for anyone who watches."""

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.product import pixels_of, shot, wait_until

pytestmark = pytest.mark.keyed("frontend/src", "server/drawing", "tests/e2e/*.py", imports=False)

AMBER = (0xE6, 0x9F, 0x00)


def amber(page: Page, left: float, right: float, bottom: float, top: float) -> int:
    """Amber pixels of the plan in a box of the plane [mm]."""
    x0, y0 = page.evaluate(f"window.__tendril.toPixel({left}, {top})")
    x1, y1 = page.evaluate(f"window.__tendril.toPixel({right}, {bottom})")
    return len(pixels_of(page, AMBER, {"x": x0, "y": y0, "width": x1 - x0, "height": y1 - y0}))


def test_vu_is_chosen_by_keyboard_seen_on_the_plan_and_cleared(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    menu = page.get_by_role("combobox", name="Reference shown on the plan")
    place = menu.bounding_box()
    menu.focus()
    page.keyboard.type("VU")
    expect(page.get_by_role("listbox").get_by_role("option")).to_have_count(1)
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("reference-facts")).to_contain_text("125 mm")
    expect(menu).to_have_value("VU")
    expect(page.get_by_role("img", name="Shape of VU")).to_be_visible()
    assert menu.bounding_box() == place, "the thumbnail pushes nothing"
    wait_until(lambda: amber(page, -53, 8, 122, 153) > 60)
    assert amber(page, -53, -40, 122, 130) == 0, "the V leaves the lower left corner of its box free"
    shot(page, "reference-light")
    page.get_by_role("button", name="Dark colours").click()
    wait_until(lambda: amber(page, -53, 8, 122, 153) > 60)
    shot(page, "reference-dark")
    page.get_by_test_id("reference-clear").click()
    wait_until(lambda: amber(page, -53, 8, 122, 153) == 0)
    expect(page.get_by_test_id("reference-facts")).to_have_count(0)
    expect(page.get_by_role("img", name="Shape of VU")).to_have_count(0)


def test_the_menu_is_grouped_by_task_and_offers_the_live_path(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    page.get_by_role("combobox", name="Reference shown on the plan").click()
    shot(page, "reference-menu")
    expect(page.get_by_text("Task 2: periodic")).to_be_attached()
    page.get_by_role("option", name="Live path").click()
    expect(page.get_by_test_id("reference-facts")).to_contain_text("30 s")
    wait_until(lambda: amber(page, 0, 250, -40, 160) > 300)
    shot(page, "reference-live-path")
