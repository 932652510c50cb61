"""A page that finds every place taken says so, and comes in when one is free."""

from pathlib import Path

from playwright.sync_api import BrowserContext, expect

from tests.e2e.product import shot
from tests.server.live_server import VIEWER_TOKEN, TestServer, free_environment


def test_a_page_too_many_says_why_it_is_not_taken_in(context: BrowserContext, tmp_path: Path) -> None:
    free_environment()
    server = TestServer(tmp_path, "tcp/127.0.0.1:9", viewers_max=1)
    try:
        page = context.new_page()
        with server.page().sign_in().live() as first:
            first.wait("hello")
            page.goto(f"{server.url}/?token={VIEWER_TOKEN}")
            expect(page.get_by_test_id("shutOut")).to_contain_text("1 pages are open, as many as viewers_max allows")
            shot(page, "shut-out")
        expect(page.get_by_test_id("banner")).to_contain_text("The server waits for a rig")
        page.close()
    finally:
        server.close()
