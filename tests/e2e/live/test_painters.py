"""A painter or a part of the page that fails takes no other with it."""

import re

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from controller.schema.modes import Mode
from tests.e2e.hand import Hand, arm
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.reviewing import review

pytestmark = pytest.mark.keyed("frontend/src", "tests/e2e/*.py", imports=False)

NO_ARCS = """() => {
  const arc = CanvasRenderingContext2D.prototype.arc;
  window.mend = () => { CanvasRenderingContext2D.prototype.arc = arc; };
  CanvasRenderingContext2D.prototype.arc = () => { throw new Error('no arc'); }; }"""
"""The layer of the plan with the actuator draws arcs; grid, plots and numbers do without."""
NO_TEXT = """() => {
  const put = Element.prototype.setAttribute;
  window.mend = () => { Element.prototype.setAttribute = put; };
  Element.prototype.setAttribute = function (name, value) {
    if (name === 'data-testid' && value === 'log') throw new Error('no log');
    return put.call(this, name, value); }; }"""
"""React fails to make the log."""


def test_a_painter_that_throws_is_marked_and_all_else_goes_on(page: Page, product: Product) -> None:
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    arm(page)
    hand = Hand(page, product)
    hand.press()
    page.evaluate(NO_ARCS)
    expect(page.get_by_test_id("not-drawn")).to_contain_text("actuator in the plan")
    hand.move(-10, -20)
    hand.wait(Mode.FOLLOW)
    page.get_by_test_id("health").dispatch_event("click")  # the mouse is down elsewhere
    age = page.get_by_test_id("command-age").inner_text()
    wait_until(lambda: page.get_by_test_id("command-age").inner_text() != age)
    page.wait_for_timeout(2500)
    shot(page, "painter-failed")
    assert len([text for text in said if "is not drawn" in text]) == 1, said
    page.get_by_role("tab", name="Log").dispatch_event("click")
    expect(page.get_by_test_id("log").get_by_text("actuator in the plan is not drawn: no arc")).to_have_count(1)
    page.evaluate("window.mend()")
    expect(page.get_by_test_id("not-drawn")).to_have_count(0)
    assert frame(page)["mode"] == Mode.FOLLOW
    hand.up()


def test_a_part_that_fails_leaves_the_others_and_comes_back(page: Page) -> None:
    page.evaluate(NO_TEXT)
    page.get_by_role("tab", name="Log").click()
    expect(page.locator(".part-failed")).to_contain_text("Log: Error: no log")
    expect(page.get_by_test_id("not-drawn")).to_contain_text("Log")
    expect(page.get_by_test_id("e-stop")).to_be_enabled()
    expect(page.get_by_test_id("plan")).to_be_visible()
    shot(page, "part-failed")
    page.evaluate("window.mend()")
    expect(page.get_by_test_id("log")).to_be_visible()
    expect(page.get_by_test_id("not-drawn")).to_have_count(0)


def test_review_whose_code_does_not_come_says_so_and_comes_later(context: BrowserContext, product: Product) -> None:
    code = re.compile(r"/assets/Review-[^/]*\.js$")
    context.route(code, lambda route: route.abort())
    page = open_page(context, product)
    review(page)
    expect(page.locator(".part-failed")).to_contain_text("Review: Error: Failed to fetch")
    expect(page.get_by_test_id("e-stop")).to_be_enabled()
    context.unroute(code)
    expect(page.locator("main.review")).to_be_visible()
    expect(page.get_by_test_id("not-drawn")).to_have_count(0)
