"""A phone alone: fingers watch, stop, hold and record, and nothing that they need is out of reach or covered."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from controller.schema.modes import Mode
from tests.e2e.edge import REACHED, ask, press, troubles
from tests.e2e.product import Product, frame, open_page, remember, shot, wait_until
from tests.e2e.reviewing import coloured
from tests.e2e.tab import end_session

pytestmark = pytest.mark.keyed("frontend/src", "server", "controller", "recordings", "tests/e2e/*.py", imports=False)
"""Of the whole product: whatever changes in it, this is tested again."""

SIZES = [(390, 844), (320, 568), (844, 390)]
NEEDED = ["stop-hold", "record", "plan"]
"""Beside state and E-STOP, which `troubles` looks at, and what leads on."""
WIDTHS = (360, 390, 430)
CUT_WORDS = """() => {
  const header = document.querySelector(".header");
  const edge = header.querySelector(".primary").getBoundingClientRect().left;
  const words = document.createTreeWalker(header, NodeFilter.SHOW_TEXT);
  const cut = [];
  while (words.nextNode()) {
    const { data, parentElement } = words.currentNode;
    const range = document.createRange();
    range.selectNode(words.currentNode);
    const { left, right } = range.getBoundingClientRect();
    const shown = parentElement.closest("button") && getComputedStyle(parentElement).position !== "absolute";
    if (shown && left < edge && edge < right && right - left > 1) cut.push(data);
  }
  return cut;
}"""
"""Words of the header's buttons that end under what leads on."""


@pytest.fixture
def phone(browser: Browser, product: Product) -> Iterator[Page]:
    """A phone's browser on the page where one signs in."""
    context = browser.new_context(
        viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True, device_scale_factor=2
    )
    remember(context, "tendril-guide", "seen")
    page = context.new_page()
    page.goto(product.origin)
    yield page
    ask(page, "DELETE", "/api/recordings/current")
    ask(page, "POST", "/api/command", request="rest")
    end_session(context)


def out_of_reach(page: Page, *test_ids: str) -> list[str]:
    """What cannot be pressed at each of the sizes, one line each."""
    found = []
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(150)
        found += troubles(page, f"{width} x {height}")
        found += [f"{width} x {height}: {amiss}" for id in test_ids if (amiss := page.evaluate(REACHED, id))]
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(150)
    return found


def cut_words(page: Page) -> list[str]:
    """What the header cuts at the widths of common phones."""
    found = []
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 844})
        page.wait_for_timeout(150)
        found += [f"{width}: {word} is cut" for word in page.evaluate(CUT_WORDS)]
    page.set_viewport_size({"width": 390, "height": 844})
    return found


def drag(page: Page, dx: float, dy: float) -> None:
    """A finger on the target, led away by so much."""
    x, y = page.evaluate("window.__tendril.handle()")
    finger = page.context.new_cdp_session(page)
    for step in range(11):
        point = {"x": x + dx * step / 10, "y": y + dy * step / 10}
        finger.send("Input.dispatchTouchEvent", {"type": "touchMove" if step else "touchStart", "touchPoints": [point]})
        page.wait_for_timeout(30)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def picture(plan: Locator) -> bytes:
    """Of what the plan shows now."""
    return plan.screenshot()


def test_a_phone_alone_can_watch_stop_hold_and_record(phone: Page, product: Product) -> None:
    state, plan = phone.get_by_test_id("state"), phone.get_by_test_id("plan")
    phone.get_by_test_id("token").tap()
    phone.keyboard.type(product.url.split("token=")[1])
    phone.get_by_test_id("sign-in").tap()
    expect(state).to_contain_text("VENTED")
    tick = frame(phone)["tick"]
    wait_until(lambda: frame(phone)["tick"] > tick)

    amiss = out_of_reach(phone, *NEEDED, "lease-take")
    phone.get_by_test_id("lease-take").tap()
    expect(phone.get_by_test_id("lease-release")).to_be_visible()
    amiss += cut_words(phone)
    phone.get_by_test_id("primary-arm").tap()
    expect(state).to_contain_text("HOLD")
    phone.get_by_test_id("record").tap()
    expect(phone.get_by_test_id("record")).to_contain_text("REC")
    phone.get_by_test_id("primary-follow").tap()
    expect(state).to_contain_text("FOLLOW")
    before = picture(plan)
    drag(phone, -20, -40)
    wait_until(lambda: frame(phone)["p_meas"][1] > 0.02)
    assert picture(plan) != before, "the plan moves"
    amiss += out_of_reach(phone, *NEEDED, "mark-button") + cut_words(phone)
    phone.get_by_test_id("stop-hold").tap()
    expect(state).to_contain_text("HOLD")

    phone.get_by_test_id("record").tap()
    expect(phone.get_by_test_id("record-profile")).to_be_visible()
    phone.get_by_text("Review", exact=True).tap()
    row = phone.get_by_test_id("recording").first
    expect(row.locator("button.link")).to_be_visible()
    shot(phone, "phone-review")
    amiss += out_of_reach(phone, "stop-hold", "recording-search", "compare-tick", "delete-recording")
    row.locator("button.link").tap()
    expect(phone.get_by_test_id("quick-plot")).to_have_count(6)
    wait_until(lambda: coloured(phone)[0] > 100)
    amiss += out_of_reach(phone, "stop-hold", "back", "export", "recording-notes", "quick-path")
    phone.get_by_test_id("export").tap()
    amiss += out_of_reach(phone, "export-format", "export-send")
    phone.get_by_role("button", name="Close").tap()

    press(phone, product, touch=True, where="phone")
    phone.get_by_text("Live", exact=True).tap()
    phone.get_by_test_id("clear-latch").tap()
    expect(state).to_contain_text("VENTED")
    phone.get_by_test_id("primary-arm").tap()
    wait_until(lambda: product.mode() == Mode.HOLD)
    assert not amiss, "\n".join(amiss)


def test_a_press_leaves_nothing_said_over_the_page(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844})
    page = open_page(context, product)
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("primary-arm")).to_be_visible()
    page.wait_for_timeout(1500)
    expect(page.get_by_role("tooltip")).to_have_count(0)
    box = page.get_by_test_id("primary-arm").bounding_box()
    assert box
    for right in range(20, 31):  # a hand makes many moves, and the page draws between them
        page.mouse.move(box["x"] + right, box["y"] + 10)
        page.wait_for_timeout(50)
    expect(page.get_by_role("tooltip")).to_contain_text("from VENTED to HOLD")
    end_session(context)
