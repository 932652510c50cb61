"""What an operator does at the rig, with mouse and keyboard in a real browser, on the twin."""

import math
import time
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from controller.schema.modes import Mode
from tests.e2e.hand import begin_circle
from tests.e2e.product import Product, frame, shot, wait_until

PRESS_WHAT_COMES = """async ([test_id, x, y]) => {
  const frame = () => new Promise(requestAnimationFrame);
  while (!document.querySelector(`[data-testid="${test_id}"]`)) await frame();
  document.querySelector(`[data-testid="${test_id}"]`).click();
  return document.elementFromPoint(x, y)?.closest("button")?.dataset.testid ?? "";
}"""
"""Presses a button in the frame in which it appears, as a double click does; says what a pointer at (x, y) hits."""
K_FF = "fetch('/api/settings').then((answer) => answer.json()).then(({ K_FF }) => K_FF)"
"""What the rig has."""
ATTEMPTS = 5
"""Drags until no pause of the machine cut one off."""
PATH_MM = [(235.0 - 70.0 * s, 60.0 + 110.0 * s) for s in np.linspace(0.0, 1.0, 40)]


@pytest.fixture
def operator(page: Page) -> Iterator[Page]:
    """The page with the lease, the rig armed and in HOLD."""
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("arm")).to_be_enabled()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    yield page
    page.get_by_role("tab", name="Control").click()
    page.get_by_test_id("disarm").click()
    wait_until(lambda: frame(page)["mode"] == Mode.VENTED)
    page.get_by_test_id("lease-release").click()


def tip_error_mm(page: Page, x_mm: float, y_mm: float) -> float:
    """Distance of the twin's true tip from a point of the plane."""
    x, y = frame(page)["twin_backbone"][-2:]
    return math.hypot(x * 1e3 - x_mm, y * 1e3 - y_mm)


def observer_error_mm(page: Page) -> float:
    """Distance between the observer's tip and the twin's true tip."""
    row = frame(page)
    return 1e3 * math.dist(row["p_hat"], row["twin_backbone"][-2:])


def drag(page: Page, points_mm: list[tuple[float, float]], seconds: float) -> list[float]:
    """Drag the target's handle along the points in about `seconds`; the observer's errors on the way [mm]."""
    page.mouse.move(*page.evaluate("window.__tendril.handle()"))
    page.mouse.down()
    errors = []
    for x, y in points_mm:
        page.mouse.move(*page.evaluate(f"window.__tendril.toPixel({x}, {y})"))
        time.sleep(seconds / len(points_mm))
        errors.append(observer_error_mm(page))
    page.mouse.up()
    return errors


def drag_to_its_end(page: Page, points_mm: list[tuple[float, float]], seconds: float) -> list[float]:
    """`drag`, again where the machine stood still for so long that the rig held, as its operator would."""
    for _ in range(ATTEMPTS):
        errors = drag(page, points_mm, seconds)
        if frame(page)["mode"] == Mode.FOLLOW:
            return errors
    raise AssertionError(f"all {ATTEMPTS} drags were cut off: {page.get_by_test_id('state').get_attribute('title')}")


def test_the_tip_follows_a_target_dragged_in_the_plan_view(operator: Page) -> None:
    errors = drag_to_its_end(operator, PATH_MM, 4.0)
    expect(operator.get_by_test_id("state")).to_contain_text("FOLLOW")
    shot(operator, "follow")
    wait_until(lambda: tip_error_mm(operator, *PATH_MM[-1]) < 3.0)
    time.sleep(1.0)
    assert tip_error_mm(operator, *PATH_MM[-1]) < 3.0
    assert float(np.sqrt(np.mean(np.square(errors)))) < 3.0
    assert len(operator.evaluate("window.__tendril.roundTrips")) >= len(PATH_MM)


def test_sensing_only_rod_6_keeps_the_loop_stable(operator: Page) -> None:
    drag_to_its_end(operator, PATH_MM[:20], 2.0)
    operator.get_by_role("tab", name="Sensing").click()
    operator.get_by_test_id("preset-rod6").click()
    wait_until(lambda: frame(operator)["sensed"] == 1 << 5)
    shot(operator, "rod6")
    speeds = []
    for _ in range(20):
        before = frame(operator)["twin_backbone"][-2:]
        time.sleep(0.1)
        speeds.append(math.dist(before, frame(operator)["twin_backbone"][-2:]) / 0.1)
    assert frame(operator)["mode"] == Mode.FOLLOW
    assert max(speeds[10:]) < 0.01
    operator.get_by_test_id("preset-tip").click()
    wait_until(lambda: frame(operator)["sensed"] == 1 << 9)


def test_the_e_stop_vents_and_needs_clear_and_a_new_arm(operator: Page) -> None:
    drag(operator, PATH_MM[:10], 1.0)
    operator.get_by_test_id("e-stop").click()
    wait_until(lambda: frame(operator)["mode"] == Mode.E_STOP)
    assert frame(operator)["pressure_cmd"] == [0.0] * 4
    shot(operator, "e-stop")
    operator.get_by_test_id("clear").first.click()
    expect(operator.get_by_test_id("state")).to_contain_text("VENTED")
    operator.get_by_test_id("arm").click()
    expect(operator.get_by_test_id("state")).to_contain_text("HOLD")


def press_twice(page: Page, first: str, then: str) -> None:
    """A double click on `first`, in whose place `then` comes; nothing but `first` is pressed."""
    button = page.get_by_test_id(first)
    box = button.bounding_box()
    assert box is not None
    middle = [box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]]
    button.click()
    assert page.evaluate(PRESS_WHAT_COMES, [then, *middle]) == ""
    page.wait_for_timeout(400)


def test_a_double_click_presses_nothing_that_takes_the_place_of_the_first(operator: Page) -> None:
    operator.get_by_test_id("e-stop").click()
    expect(operator.get_by_test_id("state")).to_contain_text("E-STOP")
    press_twice(operator, "clear-latch", "primary-arm")
    assert frame(operator)["mode"] == Mode.VENTED
    operator.get_by_test_id("primary-arm").click()
    expect(operator.get_by_test_id("state")).to_contain_text("HOLD")
    begin_circle(operator)
    press_twice(operator, "stop-run", "run")
    assert frame(operator)["mode"] == Mode.HOLD
    expect(operator.get_by_test_id("run")).to_be_visible()


def test_a_number_counts_as_it_is_typed_with_whatever_zeros(operator: Page) -> None:
    operator.get_by_role("tab", name="Gains").click()
    operator.get_by_test_id("controller").select_option("paper")
    for typed, value in (("0.10", 0.1), ("0,250", 0.25), ("1.0", 1.0)):
        operator.get_by_test_id("K_FF-x").click()
        operator.keyboard.press("Control+A")
        operator.keyboard.type(typed)
        operator.keyboard.press("Tab")
        operator.keyboard.type(typed)
        operator.keyboard.press("Enter")
        wait_until(lambda value=value: operator.evaluate(K_FF) == [value, value])  # type: ignore[misc]
    operator.get_by_test_id("gains-reset").click()


def test_a_recording_of_a_run_opens_in_the_review_tab(operator: Page, product: Product) -> None:
    operator.get_by_test_id("record").click()
    drag(operator, PATH_MM[:20], 3.0)
    operator.get_by_test_id("record").click()
    operator.get_by_text("Review", exact=True).click()
    rows = operator.get_by_test_id("recording")
    expect(rows.first).to_be_visible()
    assert rows.first.get_by_test_id("recording-gaps").inner_text() == "0", "no gap"
    rows.first.click()
    expect(operator.get_by_test_id("quick-plot")).to_have_count(6)
    shot(operator, "review")
    operator.get_by_text("Live", exact=True).click()
