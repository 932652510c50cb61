"""Prints how long a dragged target takes from the page's pointer handler to the rig's reply in the page."""

import time

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.e2e.product import Product, open_page, wait_until

pytestmark = pytest.mark.long
"""A measurement: `make test-long` prints it; that drags are followed is shown by test_operate and test_follow."""
MOVES = 400
PAUSES = (0.005, 0.025)
"""Between two moves [s], at random: those of a hand keep no step with the page's frames."""
ATTEMPTS = 5
"""Drags until one is not cut off: a busy machine that stalls loop or page makes the rig hold, as it should."""


@pytest.mark.parametrize("view", ["3D view open", "3D view collapsed"])
def test_every_moved_target_is_answered_by_the_rig(context: BrowserContext, product: Product, view: str) -> None:
    page = open_page(context, product, with_3d=view == "3D view open")
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    cut, trips = 0, drag(page)
    while not trips and cut < ATTEMPTS:
        cut, trips = cut + 1, drag(page)
    assert trips, f"all {ATTEMPTS} drags were cut off: {page.get_by_test_id('state').inner_text()}"
    p50, p99, most = np.percentile(trips, [50, 99, 100])
    print(f"\npointer handler -> rig's reply, {view}, 15 Hz p50 {p50:.1f}, p99 {p99:.1f}, max {most:.1f} ms; {cut} off")
    page.get_by_test_id("disarm").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    page.get_by_test_id("lease-release").click()


def drag(page: Page) -> list[float]:
    """Round trips [ms] of MOVES moves, all answered; none when the rig was made to hold."""
    phase = np.linspace(0.0, 4.0 * np.pi, MOVES)
    path = [
        page.evaluate(f"window.__tendril.toPixel({x}, {y})")
        for x, y in zip(235 - 20 * np.sin(phase) ** 2, 60 * np.sin(phase / 2), strict=True)
    ]
    before = page.evaluate("window.__tendril.roundTrips.length")
    pauses = np.random.default_rng(1).uniform(*PAUSES, MOVES)
    page.mouse.move(*page.evaluate("window.__tendril.handle()"))
    page.mouse.down()
    for at, pause in zip(path, pauses, strict=True):
        page.mouse.move(*at)
        time.sleep(pause)
    page.mouse.up()

    def answered() -> bool:
        return bool(page.evaluate("window.__tendril.roundTrips.length") >= before + MOVES)

    wait_until(lambda: answered() or cut_off(page))
    trips: list[float] = page.evaluate("window.__tendril.roundTrips")
    return trips[before:] if answered() else []


def cut_off(page: Page) -> bool:
    """Whether the rig no longer follows, because loop or page came too late."""
    return "FOLLOW" not in page.get_by_test_id("state").inner_text()
