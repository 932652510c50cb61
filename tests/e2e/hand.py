"""A mouse that drags the target, and what the rig's own ring has of it."""

import math
import time

import numpy as np
from playwright.sync_api import Page, expect

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, wait_until


def arm(page: Page) -> None:
    """Operate, with the rig in HOLD."""
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    if (mode := frame(page)["mode"]) != Mode.HOLD:
        page.get_by_test_id("arm" if mode == Mode.VENTED else "hold").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")


def begin_circle(page: Page) -> None:
    """Follow a circle of 4 s once; it is recorded."""
    page.get_by_role("tab", name="Run").click()
    page.get_by_role("combobox", name="Reference shown on the plan").focus()
    page.keyboard.type("Circle, 0.25")
    expect(page.get_by_role("listbox").get_by_role("option").first).to_have_text("Circle, 0.25 Hz")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("run")).to_contain_text("Go to the beginning")
    page.get_by_test_id("run").click()
    expect(page.get_by_test_id("state")).to_contain_text("TRACK")


class Hand:
    """Presses and moves; knows where its pointer is."""

    def __init__(self, page: Page, product: Product) -> None:
        self._page, self._product = page, product
        self.x, self.y = 0.0, 0.0
        self.mm_per_px = math.nan

    def press(self) -> None:
        """Press on the target where it stands; the rig follows it then."""
        self.x, self.y = self._standing()
        here, there = self._page.evaluate(
            "([x, y]) => [window.__tendril.toPlane(x, y), window.__tendril.toPlane(x + 100, y)]", [self.x, self.y]
        )
        self.mm_per_px = math.dist(here, there) / 100
        self._page.mouse.move(self.x, self.y)
        self._page.mouse.down()

    def _standing(self) -> list[float]:
        """Where the target is drawn, once the page has taken in what was done to its size or zoom."""
        places = [[math.nan] * 2]
        while len(places) < 4 or any(math.dist(places[-1], place) > 0.1 for place in places[-4:]):
            self._page.wait_for_timeout(50)
            places.append(self._page.evaluate("window.__tendril.handle()"))
        return places[-1]

    def move(self, dx: float, dy: float) -> None:
        """Move on by (dx, dy) [pixels]."""
        self.x, self.y = float(self.x + dx), float(self.y + dy)
        self._page.mouse.move(self.x, self.y)

    def up(self) -> None:
        """Let go."""
        self._page.mouse.up()

    def wait(self, mode: Mode) -> None:
        """Until the rig is in `mode`."""
        wait_until(lambda: self._product.mode() == mode)

    def target(self) -> np.ndarray:
        """The target that the rig has [mm]."""
        row = find_ring(self._product.rig).newest()
        assert row is not None
        return 1e3 * np.array(row["target"])

    def settled(self) -> np.ndarray:
        """The same, once nothing new came for a while [mm]."""
        before = self.target()
        while True:
            time.sleep(0.15)
            if np.array_equal(now := self.target(), before):
                return now
            before = now

    def rows(self, t_ns: int) -> np.ndarray:
        """What the rig did from `t_ns` on."""
        ring = find_ring(self._product.rig)
        count = min(ring.head, (time.monotonic_ns() - t_ns) // 1_000_000 + 500)
        rows = ring.read(ring.head - count, count)[1]
        return rows[rows["t_ns"] >= t_ns]
