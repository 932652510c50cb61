"""Who may do what: a viewer beside an operator, and someone without a token."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, remember, shot, wait_until
from tests.e2e.tab import end_session
from tests.e2e.ui.test_accessibility import in_both_schemes, load_axe


@pytest.fixture
def viewer(browser: Browser, product: Product) -> Iterator[Page]:
    """A second person's page, in a profile of its own."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    yield open_page(context, product)
    end_session(context)


def test_a_viewer_moves_nothing_but_may_stop(page: Page, viewer: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    expect(viewer.get_by_test_id("lease")).to_have_attribute("data-held", "true")
    expect(viewer.get_by_test_id("arm")).to_be_disabled()
    before = frame(viewer)["target"]
    x, y = viewer.evaluate("window.__tendril.handle()")
    viewer.mouse.move(x, y)
    viewer.mouse.down()
    viewer.mouse.move(x - 80, y - 80, steps=10)
    viewer.mouse.up()
    refused = viewer.request.post(
        f"{viewer.url}api/command",
        data={"request": "follow", "target": [0.2, 0.1]},
        headers={"Origin": viewer.url.rstrip("/")},
    )
    assert refused.status == 403
    assert frame(viewer)["mode"] == Mode.HOLD
    assert frame(viewer)["target"] == before
    shot(viewer, "viewer")
    viewer.get_by_test_id("e-stop").click()
    wait_until(lambda: frame(page)["mode"] == Mode.E_STOP)
    expect(viewer.get_by_test_id("clear")).to_be_disabled()
    page.get_by_test_id("clear").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")


def test_a_wrong_token_is_refused_and_a_right_one_lets_in(context: BrowserContext, product: Product) -> None:
    page = context.new_page()
    page.goto(product.origin)
    page.get_by_test_id("token").fill("not the token")
    with page.expect_response(lambda answer: answer.url.endswith("/api/session")) as answer:
        page.get_by_test_id("sign-in").click()
    assert answer.value.status == 401
    shot(page, "sign-in")
    page.get_by_test_id("token").fill(product.url.split("token=")[1])
    page.get_by_test_id("sign-in").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    assert "token" not in page.url


def test_signing_out_asks_for_the_token_in_every_tab_and_gives_control_back(
    page: Page, context: BrowserContext, browser: Browser, product: Product
) -> None:
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    copy = browser.new_context(storage_state=context.storage_state()).new_page()
    other_tab = context.new_page()
    other_tab.goto(product.origin)
    expect(other_tab.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    page.get_by_test_id("me").click()
    load_axe(page)
    assert in_both_schemes(page, "me", "[role=menu]") == []
    shot(page, "signing-out")
    page.get_by_test_id("sign-out").click()
    for tab in (page, other_tab):
        expect(tab.get_by_test_id("token")).to_be_visible()
    copy.goto(product.origin)
    expect(copy.get_by_test_id("token")).to_be_visible()
    copy.context.close()
    page.get_by_test_id("token").fill(product.url.split("token=")[1])
    page.get_by_test_id("sign-in").click()
    expect(page.get_by_test_id("lease")).to_have_attribute("data-held", "false")
    expect(other_tab.get_by_test_id("state")).to_contain_text("VENTED")
    page.get_by_test_id("me").click()
    page.get_by_test_id("sign-out-operator").click()
    shot(page, "sign-out-all")
    page.get_by_test_id("sign-out-confirm").click()
    for tab in (page, other_tab):
        expect(tab.get_by_test_id("token")).to_be_visible()


def test_a_viewer_asks_the_operator_accepts_and_takes_control_back(
    page: Page, browser: Browser, product: Product
) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    remember(context, "tendril-guide", "seen")
    remember(context, "tendril-3d", "closed")
    viewer = context.new_page()
    viewer.goto(product.ready.viewer_url)
    expect(viewer.get_by_test_id("me")).to_have_attribute("data-role", "viewer")
    expect(viewer.get_by_test_id("lease-take")).to_have_attribute("data-disabled", "true")
    page.get_by_test_id("lease-take").click()
    viewer.get_by_test_id("lease-menu").click()
    expect(viewer.get_by_test_id("lease-take-over")).to_be_disabled()
    load_axe(viewer)
    assert in_both_schemes(viewer, "control", "[role=menu]") == []
    viewer.get_by_test_id("lease-ask").click()
    expect(page.get_by_test_id("asking")).to_contain_text("(viewer) asks for control")
    load_axe(page)
    assert in_both_schemes(page, "asked", ".header") == []
    shot(page, "asked-for-control")
    page.get_by_test_id("ask-accept").click()
    expect(viewer.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    expect(viewer.get_by_text("You operate now")).to_be_visible()
    viewer.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_test_id("lease-menu").click()
    page.get_by_test_id("lease-take-over").click()
    assert in_both_schemes(page, "take over", "[role=dialog]") == []
    shot(page, "take-over")
    page.get_by_test_id("take-over-confirm").click()
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    expect(viewer.get_by_text("You no longer operate")).to_be_visible()
    expect(viewer.get_by_test_id("lease-take")).to_have_attribute("data-disabled", "true")
    page.get_by_test_id("lease-release").click()
    end_session(context)
