"""The browser's notifications: asked for by a click, shown only where no one looks."""

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.e2e.edge import ask, clear
from tests.e2e.product import Product, open_page, shot, wait_until

pytestmark = pytest.mark.keyed("frontend/src", "server/health", "tests/e2e/*.py", imports=False)

STUB = """
  window.told = []; window.asked = 0;
  window.Notification = class {
    static permission = "default";
    static requestPermission = async () => { window.asked += 1; return (window.Notification.permission = "granted"); };
    constructor(title, options) { window.told.push(`${title} | ${options.body}`); }
    close() {}
  };
  document.hasFocus = () => window.looks ?? true;
"""
"""Chromium without a screen shows none: what the page asks of it is kept instead."""


def told(page: Page) -> list[str]:
    return list(page.evaluate("window.told"))


def stop_and_clear(page: Page, product: Product) -> None:
    """An E-STOP and out of it again, as another page would ask for."""
    wait_until(lambda: ask(page, "POST", "/api/command", request="e_stop"))
    expect(page.get_by_test_id("state")).to_contain_text("E-STOP")
    clear(page, product)


def test_it_is_asked_by_a_click_and_told_only_while_nobody_looks(context: BrowserContext, product: Product) -> None:
    context.add_init_script(STUB)
    page = open_page(context, product)
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    assert page.evaluate("window.asked") == 0
    page.get_by_test_id("notify").click()
    page.get_by_test_id("notify-on").click()
    expect(page.get_by_test_id("notify-on")).to_be_checked()
    shot(page, "notify")
    page.get_by_test_id("notify-test").click()
    assert page.evaluate("window.asked") == 1 and told(page)[0].startswith("Tendril: test")
    stop_and_clear(page, product)
    assert len(told(page)) == 1, "someone looks"
    page.evaluate("window.looks = false")
    stop_and_clear(page, product)
    assert [text.split(" | ")[0] for text in told(page)] == ["Tendril: test", "Tendril: E-STOP"]
