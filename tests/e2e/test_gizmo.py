"""The 3D view: dragging viser's gizmo moves the same target as the plan view."""

import math
import time

from playwright.sync_api import BrowserContext, Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, pixels_of, shot, wait_until

BLUE = (54, 142, 226)
"""The square of viser's transform control for the xy plane, as it is drawn."""


def gizmo(page: Page) -> tuple[float, float] | None:
    """Where the gizmo is drawn [window pixels], None while it is not; only pixels tell: it has its own process."""
    box = page.locator("iframe[title*='3D']").bounding_box()
    assert box
    found = pixels_of(page, BLUE, dict(box))
    return tuple(found.mean(axis=0)) if len(found) > 8 else None


def test_dragging_the_gizmo_moves_the_target_and_the_tip_follows(context: BrowserContext, product: Product) -> None:
    page = open_page(context, product, with_3d=True)
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    wait_until(lambda: gizmo(page), 60.0)
    at = gizmo(page)
    assert at
    before = frame(page)["p_ref"]
    page.mouse.move(*at)
    time.sleep(1.0)  # software rendering: the gizmo must have seen the pointer over it
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(at[0] - 2 * step, at[1] - 3 * step)
        time.sleep(0.2)
    wait_until(lambda: math.dist(before, frame(page)["target"]) > 0.02, 10.0)
    assert frame(page)["mode"] == Mode.FOLLOW
    there = frame(page)["target"]
    page.get_by_test_id("toggle-3d").evaluate("bar => { bar.parentElement.style.height = '90px' }")
    wait_until(lambda: frame(page)["mode"] == Mode.HOLD, 10.0)
    page.mouse.move(at[0] - 60, at[1] - 90)
    time.sleep(0.5)
    assert frame(page)["mode"] == Mode.HOLD, "a drag whose frame moved is over"
    assert math.dist(there, frame(page)["target"]) < 1e-3
    page.mouse.up()
    page.get_by_test_id("follow").click()
    wait_until(lambda: math.dist(frame(page)["p_meas"], frame(page)["target"]) < 5e-3, 10.0)
    shot(page, "gizmo")
    page.get_by_test_id("disarm").click()
    wait_until(lambda: frame(page)["mode"] == Mode.VENTED, 8.0)
    page.get_by_test_id("lease-release").click()
