"""Prints how long a dragged target takes from the page's pointer handler to the rig's reply in the page."""

import time

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from tests.e2e.product import wait_until

MOVES = 400
PERIOD = 0.015


@pytest.mark.parametrize("view", ["3D view open", "3D view collapsed"])
def test_every_moved_target_is_answered_by_the_rig(page: Page, view: str) -> None:
    if view == "3D view collapsed":
        page.get_by_test_id("toggle-3d").click()
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    phase = np.linspace(0.0, 4.0 * np.pi, MOVES)
    path = [
        page.evaluate(f"window.__tendril.toPixel({x}, {y})")
        for x, y in zip(235 - 20 * np.sin(phase) ** 2, 60 * np.sin(phase / 2), strict=True)
    ]
    page.mouse.move(*page.evaluate("window.__tendril.handle()"))
    page.mouse.down()
    for at in path:
        page.mouse.move(*at)
        time.sleep(PERIOD)
    page.mouse.up()
    wait_until(lambda: page.evaluate("window.__tendril.roundTrips.length") >= MOVES, 5.0)
    trips = np.percentile(page.evaluate("window.__tendril.roundTrips"), [50, 99, 100])
    print(f"\npointer handler -> rig's reply, {view}: p50 {trips[0]:.1f}, p99 {trips[1]:.1f}, max {trips[2]:.1f} ms")
    page.get_by_test_id("disarm").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED", timeout=10_000)
    page.get_by_test_id("lease-release").click()
