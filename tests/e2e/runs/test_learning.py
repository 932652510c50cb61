"""A drawn path that is learned by one button: the error falls on the card, the best is followed, and forgotten."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.edge import troubles
from tests.e2e.product import shot, wait_until
from tests.e2e.strokes import draw, fact

pytestmark = pytest.mark.keyed("frontend/src", "server/runs", "controller/reference", "tests/e2e/*.py", imports=False)

LOOP_MM = [(170.0, 60.0), (200.0, 60.0), (200.0, 90.0), (170.0, 90.0), (170.0, 62.0)]


def errors(page: Page) -> list[float]:
    """RMSE of the repeats so far, as the card has them [mm]."""
    return [
        float(text)
        for text in re.findall(r"([\d.]+) mm", page.get_by_test_id("learned-bars").get_attribute("aria-label") or "")
    ]


def test_a_drawing_is_learned_by_one_button_and_forgotten(page: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    page.get_by_test_id("tool-freehand").click()
    draw(page, LOOP_MM)
    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("timing").select_option("duration")
    page.get_by_test_id("duration").fill("1.5")
    wait_until(lambda: fact(page, "Duration") != "")
    page.get_by_test_id("learn").click()
    expect(page.get_by_test_id("macro-bar")).to_contain_text("Learning Drawing: repeat 1 of 8")
    expect(page.get_by_test_id("macro-bar")).to_contain_text("repeat 4 of 8")
    expect(page.get_by_test_id("run-learned")).to_contain_text("Repeat 3: best")
    expect(page.get_by_test_id("run-forget")).to_have_attribute("aria-disabled", "true")
    assert troubles(page, "learning") == []
    shot(page, "learning-under-way")
    found = errors(page)
    assert len(found) == 3 and min(found[1:]) < 0.9 * found[0], found
    page.get_by_test_id("macro-stop").click()
    expect(page.get_by_test_id("macro-bar")).to_have_count(0)

    page.get_by_test_id("run").click()
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")
    expect(page.get_by_test_id("run-learned")).to_contain_text("Learned in 3 repeats: best")
    shot(page, "learning-followed")
    page.get_by_test_id("run-forget").click()
    expect(page.get_by_test_id("run-learned")).to_have_count(0)
    page.get_by_role("tab", name="Control").click()
    page.get_by_test_id("disarm").click()
    page.get_by_test_id("lease-release").click()
