"""A page that is touched and left: it locks itself, only the stops act, and the confirmation of choice unlocks it."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.modes import Mode
from tests.e2e.edge import ask, clear, press, troubles
from tests.e2e.hand import arm
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.tab import end_session
from tests.e2e.ui.test_accessibility import in_both_schemes, load_axe

pytestmark = pytest.mark.keyed(
    "frontend/src",
    "server",
    "controller",
    "recordings",
    "tests/e2e/*.py",
    "tests/e2e/ui/test_accessibility.py",
    imports=False,
)
"""Of the whole product: whatever changes in it, this is tested again."""

CLOCK = "const now = Date.now; window.lateBy = 0; Date.now = () => now() + window.lateBy"

HEARD = """() => {
  window.heard = new Promise((done) =>
    addEventListener("message", ({ data }) => data.tendril === "touched" && done(null)));
}"""


@pytest.fixture
def touched(browser: Browser, product: Product) -> Iterator[Page]:
    """A phone's page that operates, the rig in HOLD, and a clock that can be put forward."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    context.add_init_script(CLOCK)
    page = open_page(context, product)
    arm(page)
    yield page
    ask(page, "POST", "/api/command", request="rest")
    end_session(context)


def choose(page: Page, after: str, by: str) -> None:
    """In the header's menu."""
    page.get_by_test_id("lock-menu").tap()
    page.get_by_test_id("lock-after").select_option(after)
    page.get_by_test_id("lock-by").select_option(by)
    page.get_by_test_id("lock-menu").tap()
    expect(page.get_by_test_id("lock-now")).to_have_count(0)


def leave(page: Page, seconds: float) -> None:
    """No one touches the page for so long."""
    page.evaluate(f"window.lateBy += {1e3 * seconds}")
    expect(page.get_by_test_id("lock")).to_be_visible()


def slide(page: Page, test_id: str, to: float) -> None:
    """Put a finger on the left end of an element, and lead it `to` a share of its width."""
    box = page.get_by_test_id(test_id).bounding_box()
    assert box is not None
    finger, y = page.context.new_cdp_session(page), box["y"] + box["height"] / 2
    for step in range(21):
        point = {"x": box["x"] + 30 + (box["width"] - 34) * to * step / 20, "y": y}
        finger.send("Input.dispatchTouchEvent", {"type": "touchMove" if step else "touchStart", "touchPoints": [point]})
        page.wait_for_timeout(20)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_a_page_left_alone_moves_nothing_and_stops_until_it_is_unlocked(touched: Page, product: Product) -> None:
    choose(touched, "30", "slide")
    touched.get_by_test_id("primary-follow").tap()
    wait_until(lambda: product.mode() == Mode.FOLLOW)
    x, y = touched.evaluate("window.__tendril.handle()")
    leave(touched, 31)
    shot(touched, "lock-slide-390")
    before, finger = frame(touched)["target"], touched.context.new_cdp_session(touched)
    for step in range(11):
        point = {"x": x + 4, "y": y - 5 * step}
        finger.send("Input.dispatchTouchEvent", {"type": "touchMove" if step else "touchStart", "touchPoints": [point]})
        touched.wait_for_timeout(30)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    for key in ("ArrowLeft", "f", "r", "Tab", "Enter"):
        touched.keyboard.press(key)
    assert frame(touched)["target"] == before and product.mode() == Mode.FOLLOW
    assert touched.evaluate("document.querySelector('#root').inert")
    touched.get_by_test_id("stop-hold").tap()
    wait_until(lambda: product.mode() == Mode.HOLD)
    assert troubles(touched, "locked") == []
    press(touched, product, touch=True, where="locked")
    box = touched.get_by_test_id("unlock").bounding_box()
    assert box is not None
    touched.touchscreen.tap(box["x"] + box["width"] - 10, box["y"] + box["height"] / 2)
    slide(touched, "unlock", 0.7)
    expect(touched.get_by_test_id("unlock"), "let go on the way").to_have_value("0")
    slide(touched, "unlock", 1.0)
    expect(touched.get_by_test_id("lock")).to_have_count(0)
    clear(touched, product)


def test_it_is_unlocked_by_a_number_a_long_press_and_by_keys_and_a_reload_does_not(
    touched: Page, product: Product
) -> None:
    load_axe(touched)
    choose(touched, "120", "number")
    leave(touched, 121)
    findings = in_both_schemes(touched, "locked, number", ".lock")
    touched.reload()
    unlock = touched.get_by_test_id("unlock")
    expect(unlock).to_be_visible()
    wanted = int(unlock.get_attribute("data-wanted") or "")
    unlock.fill(str(10 + (wanted - 9) % 90))
    expect(unlock).to_have_value("")
    unlock.fill(unlock.get_attribute("data-wanted") or "")
    expect(touched.get_by_test_id("lock")).to_have_count(0)

    choose(touched, "0", "hold")
    touched.get_by_test_id("lock-menu").tap()
    touched.get_by_test_id("lock-now").tap()
    load_axe(touched)
    findings += in_both_schemes(touched, "locked, hold", ".lock")
    unlock.tap()
    shot(touched, "lock-hold-390")
    expect(touched.get_by_test_id("lock")).to_be_visible()
    unlock.focus()
    touched.keyboard.down(" ")
    expect(touched.get_by_test_id("lock")).to_have_count(0)
    touched.keyboard.up(" ")

    touched.set_viewport_size({"width": 1280, "height": 720})
    choose(touched, "0", "slide")
    touched.get_by_test_id("lock-menu").tap()
    touched.get_by_test_id("lock-now").tap()
    findings += in_both_schemes(touched, "locked, slide", ".lock")
    expect(touched.get_by_test_id("stop-hold")).to_be_visible()
    assert troubles(touched, "locked, large") == []
    shot(touched, "lock-slide-1280")
    unlock.focus()
    for _ in range(20):
        touched.keyboard.press("ArrowRight")
    expect(touched.get_by_test_id("lock")).to_have_count(0)
    assert not findings, "\n".join(findings)


def test_a_hand_in_the_3d_view_counts_as_a_touch(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, has_touch=True)
    context.add_init_script(CLOCK)
    page = open_page(context, product, with_3d=True)
    choose(page, "30", "slide")
    view = page.locator("iframe[title*='3D']")
    expect(view.content_frame.locator("canvas").first).to_be_visible()
    box = view.bounding_box()
    assert box is not None
    for dx in (40, 60, 80):
        page.evaluate(HEARD)
        page.mouse.move(box["x"] + dx, box["y"] + 40)
        page.evaluate("window.heard")
        page.evaluate("window.lateBy += 20_000")
        page.wait_for_timeout(1100)  # the page looks twice a second, its frame tells once a second
        expect(page.get_by_test_id("lock")).to_have_count(0)
    leave(page, 31)
    end_session(context)


def test_a_screen_that_is_not_touched_has_no_lock(page: Page) -> None:
    expect(page.get_by_test_id("state")).to_be_visible()
    expect(page.get_by_test_id("lock-menu")).to_have_count(0)
