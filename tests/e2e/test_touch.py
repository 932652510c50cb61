"""A finger on the plan view, as a tablet sends it."""

import math

from playwright.sync_api import Browser, expect

from controller.modes import Mode
from tests.e2e.product import Product, frame, open_page, wait_until


def test_a_finger_drags_the_target(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, has_touch=True)
    page = open_page(context, product)
    page.get_by_test_id("toggle-3d").tap()
    page.get_by_test_id("lease-take").tap()
    page.get_by_test_id("arm").tap()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    finger = context.new_cdp_session(page)
    x, y = page.evaluate("window.__tendril.handle()")
    finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x + 6, "y": y}]})
    for step in range(1, 21):
        point = {"x": x + 6 - step, "y": y - 4 * step}
        finger.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [point]})
        page.wait_for_timeout(30)
    wait_until(lambda: frame(page)["target"][1] > 0.08, 5.0)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert frame(page)["mode"] == Mode.FOLLOW
    wait_until(lambda: math.dist(frame(page)["p_meas"], frame(page)["target"]) < 5e-3, 10.0)
    context.close()
