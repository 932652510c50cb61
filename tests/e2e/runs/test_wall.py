"""The large numbers: legible across the room, true, and with E-STOP in reach."""

import math
import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.edge import ask, clear, press, troubles
from tests.e2e.product import Product, frame, shot, wait_until

pytestmark = pytest.mark.keyed("frontend/src", "server/runs", "tests/e2e/*.py", imports=False)

SIZES = [(1920, 1080), (1280, 720), (390, 844)]
CAP_HEIGHT = 0.7
"""Of capitals and digits, as a share of the font's size."""
LEGIBLE = 85.0
"""Height of a digit [CSS px] on 1920 x 1080: 24 mm on a 24" screen, 1/200 of 5 m."""
CUT = """() => [...document.querySelectorAll(".wall-number .number")]
  .filter((one) => one.scrollWidth > one.parentElement.clientWidth + 1).map((one) => one.dataset.testid)"""


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_nothing_is_cut_and_the_e_stop_is_in_reach(width: int, height: int, page: Page, product: Product) -> None:
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("location.hash = '#wall'")
    expect(page.get_by_test_id("wall-state")).to_contain_text("VENTED")
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        shot(page, f"wall-{width}-{scheme}")
    assert page.evaluate(CUT) == []
    assert troubles(page, "wall") == []
    press(page, product, touch=False, where="wall")
    expect(page.get_by_test_id("wall-state")).to_contain_text("E-STOP")
    clear(page, product)
    ask(page, "DELETE", "/api/lease")


def test_the_numbers_are_those_of_the_rig_and_are_read_from_five_metres(page: Page) -> None:
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.get_by_test_id("wall-open").click()
    x = page.get_by_test_id("wall-tip-x")
    expect(x).to_have_text(re.compile(r"^-?[0-9]+\.[0-9]$"))
    row = frame(page)
    assert math.isclose(float(x.inner_text()), row["p_meas"][0] * 1e3, abs_tol=2.0)  # vented: noise alone
    size = float(x.evaluate("(one) => parseFloat(getComputedStyle(one).fontSize)"))
    assert size * CAP_HEIGHT >= LEGIBLE
    page.get_by_test_id("wall-close").click()
    expect(page.get_by_test_id("plan")).to_be_visible()
