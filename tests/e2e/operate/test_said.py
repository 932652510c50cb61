"""What the page says where nothing moves: which link is silent, why a press did nothing, who has control and why."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.modes import Mode
from tests.e2e.edge import ask, clear, press
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.tab import end_session

pytestmark = pytest.mark.keyed("frontend/src", "server", "controller", "recordings", "tests/e2e/*.py", imports=False)
"""Of the whole product: whatever changes in it, this is tested again."""

SIZES = {"1440": (1440, 900), "390": (390, 844)}
WORDS = """() => {
  const state = document.querySelector("[data-testid=state]").parentElement;
  window.words = new Set();
  new MutationObserver(() => window.words.add(state.querySelector("[data-testid=state]").textContent))
    .observe(state, { subtree: true, childList: true, characterData: true });
}"""
"""Keep every word that stands in the state's place from now on."""


@pytest.fixture(params=SIZES)
def page(browser: Browser, product: Product, request: pytest.FixtureRequest) -> Iterator[Page]:
    """A page that may operate, large and small."""
    width, height = SIZES[request.param]
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme="dark")
    found = open_page(context, product)
    yield found
    end_session(context)


def is_calm(page: Page) -> bool:
    """Whether the state's word stays for a second: a page that has just begun may have been silent itself."""
    page.evaluate("window.words.clear()")
    page.wait_for_timeout(1000)
    return page.evaluate("window.words.size") == 0 and "VENTED" in page.get_by_test_id("state").inner_text()


def is_laid_out(page: Page) -> bool:
    """Whether the plan stays where it is: a page that has just begun takes in what is shown on it, and fits that."""
    before = page.evaluate("window.__tendril.toPixel(0, 0)")
    page.wait_for_timeout(500)
    return bool(page.evaluate("window.__tendril.toPixel(0, 0)") == before)


def test_a_server_that_says_nothing_is_named_and_not_its_rig(page: Page, product: Product) -> None:
    server = product.child("server.app")
    page.evaluate(WORDS)
    wait_until(lambda: is_calm(page))
    server.suspend()
    try:
        expect(page.get_by_test_id("banner")).to_contain_text("No connection to the server")
        expect(page.get_by_test_id("state")).to_contain_text("NO LINK")
        words = page.evaluate("[...window.words]")
        shot(page, f"said-silent-{page.viewport_size['width']}")  # type: ignore[index]
    finally:
        server.resume()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    assert words == ["NO LINK"], "while it was silent"


def test_review_says_why_the_rig_stopped_and_what_leads_out(page: Page, product: Product) -> None:
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    page.get_by_text("Review", exact=True).click()
    press(page, product, touch=False, where="review")
    expect(page.locator(".over-place").get_by_test_id("latched")).to_be_visible()
    expect(page.locator(".over-place").get_by_test_id("latched")).to_contain_text("then press Clear E-STOP")
    shot(page, f"said-review-{page.viewport_size['width']}")  # type: ignore[index]
    clear(page, product)


def test_a_press_of_the_target_without_control_says_so_there_and_pans_nothing(page: Page, product: Product) -> None:
    expect(page.get_by_test_id("lease")).to_have_attribute("data-held", "false")
    wait_until(lambda: is_laid_out(page))
    x, y = page.evaluate("window.__tendril.handle()")
    before = page.evaluate("window.__tendril.toPixel(0, 0)")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y + 30, steps=5)
    hint = page.get_by_test_id("hint")
    expect(hint).to_have_text("Take control first")
    shot(page, f"said-hint-{page.viewport_size['width']}")  # type: ignore[index]
    box = hint.bounding_box()
    assert box is not None
    assert y - 120 < box["y"] + box["height"] / 2 < y
    page.mouse.up()
    assert page.evaluate("window.__tendril.toPixel(0, 0)") == before


def test_control_that_is_taken_over_is_said_with_by_whom(page: Page, browser: Browser, product: Product) -> None:
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    other = open_page(context, product)
    other.get_by_test_id("lease-menu").click()
    other.get_by_test_id("lease-take-over").click()
    other.get_by_test_id("take-over-confirm").click()
    expect(page.get_by_test_id("hint")).to_contain_text("took control over")
    shot(page, f"said-lost-{page.viewport_size['width']}")  # type: ignore[index]
    assert frame(page)["mode"] == Mode.VENTED
    end_session(context)
