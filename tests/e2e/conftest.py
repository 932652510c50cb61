"""Fixtures of the browser tests: a running product and a page on it."""

import os
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from server.app.browser import launch_chromium
from tests.e2e.at_rest import Caretaker
from tests.e2e.product import PATIENCE_S, Product, open_page
from tests.e2e.tab import WINDOW, Tab, end_session, policy_breaches

expect.set_options(timeout=1e3 * PATIENCE_S)


@pytest.fixture(scope="session")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Product, Caretaker]]:
    """One running product for all tests: to start it takes longer than most of them.

    Its pages get 15 records a second, which is enough to see by; the programs that measure run it as it is.
    """
    os.environ["TENDRIL_FRAME_RATE"] = "15"
    with Product(tmp_path_factory.mktemp("product")) as product:
        caretaker = Caretaker(product)
        yield product, caretaker
        caretaker.close()


@pytest.fixture(scope="module")
def product(running: tuple[Product, Caretaker]) -> Iterator[Product]:
    """The product, at rest before every module."""
    product, caretaker = running
    caretaker.put_to_rest()
    yield product


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's chromium, software rendering."""
    with launch_chromium() as launched:
        yield launched


@pytest.fixture(autouse=True)
def nobody_stays(browser: Browser, tab: Tab) -> Iterator[None]:
    """What a test that failed has left open may not go on to operate: it would keep the lease from all others."""
    before = [*browser.contexts]
    yield
    for left in [context for context in browser.contexts if context not in (*before, tab.context)]:
        end_session(left)


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A fresh profile: its own cookies, so its own session. Our page itself may not break its security policy."""
    opened = browser.new_context(viewport=WINDOW)
    said = policy_breaches(opened)
    yield opened
    end_session(opened)
    assert said == []


@pytest.fixture(scope="session")
def tab(browser: Browser) -> Iterator[Tab]:
    """One for all tests that ask for no context of their own."""
    found = Tab(browser)
    yield found
    found.close()


@pytest.fixture
def page(request: pytest.FixtureRequest, product: Product) -> Iterator[Page]:
    """The page, signed in by the address that `tendril up` prints, in a session of its own.

    A test that asks for `context` has its page in that one.
    """
    if "context" in request.node.fixturenames:
        yield open_page(request.getfixturevalue("context"), product)
        return
    tab: Tab = request.getfixturevalue("tab")
    failed = request.session.testsfailed
    yield tab.open(product)
    tab.leave(sound=request.session.testsfailed == failed)
