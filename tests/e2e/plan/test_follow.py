"""A hand on the live target: finger, arrow keys and gamepad, with the held clutch and after a stop."""

import math
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, wait_until

GAMEPAD = """
const pad = { id: "Test pad (STANDARD GAMEPAD Vendor: 0)", index: 0, connected: true, mapping: "standard",
  axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 })) };
window.pad = pad;
navigator.getGamepads = () => [pad];
window.plugIn = () => window.dispatchEvent(new Event("gamepadconnected"));
"""
REACHED_MM = (230.0, 85.0)
"""A place that the tip comes to from wherever it was left."""


@pytest.fixture(scope="module")
def armed(browser: Browser, product: Product) -> Iterator[Page]:
    """A tablet's page with a gamepad, the lease, and the rig in HOLD."""
    context = browser.new_context(viewport={"width": 1280, "height": 720}, has_touch=True)
    context.add_init_script(GAMEPAD)
    page = open_page(context, product, smooth=True)
    page.get_by_test_id("lease-take").tap()
    page.get_by_test_id("arm").tap()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    yield page
    page.get_by_test_id("lease-release").tap()
    context.close()


def wait_mode(page: Page, mode: Mode) -> None:
    """Wait until telemetry says `mode`."""
    wait_until(lambda: frame(page)["mode"] == mode)


def go_on(page: Page) -> None:
    """Follow again where the machine stood still for so long that the rig holds, as its operator would."""
    if frame(page)["mode"] == Mode.HOLD:
        page.get_by_test_id("follow").tap()


def test_a_finger_drags_the_target(armed: Page) -> None:
    finger = armed.context.new_cdp_session(armed)
    x, y = armed.evaluate("window.__tendril.handle()")
    finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x + 6, "y": y}]})
    to_x, to_y = armed.evaluate(f"window.__tendril.toPixel({REACHED_MM[0]}, {REACHED_MM[1]})")
    for step in range(1, 21):
        point = {"x": x + 6 + (to_x - x) * step / 20, "y": y + (to_y - y) * step / 20}
        finger.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [point]})
        armed.wait_for_timeout(30)
    wait_until(lambda: math.dist(frame(armed)["target"], [1e-3 * mm for mm in REACHED_MM]) < 2e-3)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert frame(armed)["mode"] == Mode.FOLLOW
    wait_until(lambda: math.dist(frame(armed)["p_meas"], frame(armed)["target"]) < 5e-3, each=lambda: go_on(armed))


def test_with_the_held_clutch_letting_go_of_an_arrow_key_or_of_the_gamepad_holds(armed: Page) -> None:
    armed.get_by_test_id("clutch").click()
    expect(armed.get_by_test_id("clutch")).to_be_checked()
    wait_mode(armed, Mode.HOLD)
    expect(armed.get_by_test_id("follow")).to_have_attribute("aria-disabled", "true")
    armed.get_by_test_id("plan").focus()
    before = frame(armed)["p_ref"]
    armed.keyboard.down("ArrowLeft")
    wait_mode(armed, Mode.FOLLOW)
    assert frame(armed)["target"][0] < before[0]
    armed.keyboard.up("ArrowLeft")
    wait_mode(armed, Mode.HOLD)
    armed.evaluate("window.plugIn()")
    expect(armed.get_by_test_id("gamepad")).to_contain_text("Test pad")
    armed.evaluate("pad.axes[0] = -1")
    armed.wait_for_timeout(100)
    assert frame(armed)["mode"] == Mode.HOLD, "the stick alone moves nothing"
    armed.evaluate("pad.buttons[0].pressed = true")
    wait_mode(armed, Mode.FOLLOW)
    start = frame(armed)["target"][0]
    wait_until(lambda: frame(armed)["target"][0] < start - 0.01)
    armed.keyboard.press("Escape")
    wait_mode(armed, Mode.HOLD)
    held = frame(armed)["p_ref"]
    armed.wait_for_timeout(200)
    assert frame(armed)["mode"] == Mode.HOLD, "after a stop the held button is no press"
    assert math.dist(held, frame(armed)["p_ref"]) < 1e-4
    armed.evaluate("pad.buttons[0].pressed = false")
    armed.wait_for_timeout(60)
    armed.evaluate("pad.buttons[0].pressed = true")
    wait_mode(armed, Mode.FOLLOW)
    armed.evaluate("pad.buttons[0].pressed = false")
    wait_mode(armed, Mode.HOLD)
    armed.get_by_test_id("clutch").click()
    expect(armed.get_by_test_id("clutch")).not_to_be_checked()


def test_the_limits_of_a_live_target_are_set_beside_it(armed: Page) -> None:
    armed.get_by_test_id("limit-speed_max").fill("50")
    armed.get_by_test_id("limit-speed_max").press("Enter")
    expect(armed.get_by_test_id("limit-speed_max")).to_have_value("50")
    armed.get_by_role("tab", name="Log").click()
    expect(armed.get_by_test_id("log")).to_contain_text("speed_max = 0.05")
