"""One browser tab for many tests: a page in a new one takes four times the processor's time to open."""

import contextlib
from urllib.parse import urlsplit

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Error, Page, ViewportSize

from tests.e2e.product import Product, go_to, open_page

WINDOW = ViewportSize(width=1280, height=720)


def policy_breaches(context: BrowserContext) -> list[str]:
    """What is said of our page's security policy from now on.

    The frames of viser and rerun may try: that they fetch fonts and report home is what the policy is there to forbid.
    """
    said: list[str] = []

    def note(message: ConsoleMessage) -> None:
        ours = "/viser/" not in message.location["url"] and "/rerun/" not in message.location["url"]
        if ours and "Content Security Policy" in message.text:
            said.append(message.text)

    context.on("console", note)
    return said


def sign_off(context: BrowserContext) -> None:
    """Give back the control that one of its pages may have, for which the next test would wait until it lapses."""
    for origin in {urlsplit(page.url)._replace(path="", query="", fragment="").geturl() for page in context.pages}:
        if origin.startswith("http"):
            with contextlib.suppress(Error):  # its server may be gone
                context.request.delete(f"{origin}/api/lease", headers={"origin": origin})


def end_session(context: BrowserContext) -> None:
    """Close it; the control that its page may have is given back first."""
    sign_off(context)
    context.close()


class Tab:
    """A tab that is as good as new for every test: no cookie, nothing stored, intercepted or emulated."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self.context: BrowserContext | None = None
        self._breaches: list[str] = []

    def open(self, product: Product) -> Page:
        """The page in a session of its own."""
        if self.context is None:
            self.context = self._browser.new_context(viewport=WINDOW)
            self._breaches = policy_breaches(self.context)
            return open_page(self.context, product)
        return go_to(self.context.pages[0], product)

    def leave(self, sound: bool) -> None:
        """Make it as good as new; a tab whose test has failed, or has closed its page, is not used again."""
        assert self.context is not None
        pages, breaches = self.context.pages, [*self._breaches]
        self._breaches.clear()
        if sound and pages:
            for other in pages[1:]:
                other.close()
            self._clear(self.context, pages[0])
        else:
            self.close()
        assert breaches == []

    def _clear(self, context: BrowserContext, page: Page) -> None:
        origin = page.evaluate("location.origin")
        sign_off(context)
        page.goto("about:blank")
        page.mouse.up()
        page.unroute_all()
        context.set_offline(False)
        page.set_viewport_size(WINDOW)
        page.emulate_media(media="null", color_scheme="null", forced_colors="null", reduced_motion="null")
        context.clear_cookies()
        browser = context.new_cdp_session(page)
        browser.send("Storage.clearDataForOrigin", {"origin": origin, "storageTypes": "local_storage,indexeddb"})
        browser.detach()

    def close(self) -> None:
        """Close it."""
        if self.context is not None:
            self.context.close()
        self.context = None
