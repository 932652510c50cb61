"""Fixtures of the browser tests: a running product and a page on it."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from server.app.browser import launch_chromium
from tests.e2e.at_rest import Caretaker
from tests.e2e.product import Product, open_page

expect.set_options(timeout=30_000)
"""A machine may be busy, so no test asserts a time."""


@pytest.fixture(scope="session")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Product, Caretaker]]:
    """One running product for all tests: to start it takes longer than most of them."""
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
def nobody_stays(browser: Browser) -> Iterator[None]:
    """What a test that failed has left open may not go on to operate: it would keep the lease from all others."""
    before = [*browser.contexts]
    yield
    for left in [context for context in browser.contexts if context not in before]:
        left.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A fresh profile: its own cookies, so its own session. Our page itself may not break its security policy.

    The frames of viser and rerun may try: that they fetch fonts and report home is what the policy is there to forbid.
    """
    opened = browser.new_context(viewport={"width": 1280, "height": 720})
    said: list[tuple[str, str]] = []
    opened.on("console", lambda message: said.append((message.location["url"], message.text)))
    yield opened
    opened.close()
    ours = [text for url, text in said if "/viser/" not in url and "/rerun/" not in url]
    assert [text for text in ours if "Content Security Policy" in text] == []


@pytest.fixture
def page(context: BrowserContext, product: Product) -> Page:
    """The page, signed in by the address that `tendril up` prints."""
    return open_page(context, product)
