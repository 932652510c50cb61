"""The 3D view: dragging viser's gizmo moves the same target as the plan view."""

import math
import time

from playwright.sync_api import Page, expect

from controller.modes import Mode
from tests.e2e.product import frame, shot, wait_until


def test_dragging_the_gizmo_moves_the_target_and_the_tip_follows(page: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    shot(page, "gizmo-before")
    start = page.evaluate("window.__tendril.gizmo?.() ?? null")
    assert start is None or len(start) == 2
    before = frame(page)["target"]
    box = page.locator("iframe[title*='3D']").bounding_box()
    assert box
    x, y = GIZMO_SHARE[0] * box["width"] + box["x"], GIZMO_SHARE[1] * box["height"] + box["y"]
    page.mouse.move(x, y)
    time.sleep(0.5)
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(x - 2 * step, y - 2 * step)
        time.sleep(0.1)
    page.mouse.up()
    wait_until(lambda: frame(page)["mode"] == Mode.FOLLOW, 5.0)
    moved = math.dist(before, frame(page)["target"])
    assert moved > 0.005
    wait_until(lambda: math.dist(frame(page)["p_meas"], frame(page)["target"]) < 5e-3, 8.0)
    shot(page, "gizmo-after")


GIZMO_SHARE = (0.72, 0.45)
