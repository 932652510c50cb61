"""What someone finds who signs in with the viewer's token."""

from pathlib import Path

from playwright.sync_api import Browser, expect

from tests.e2e.product import shot
from tests.server.live_server import VIEWER_TOKEN, TestServer, free_environment


def test_a_viewers_guide_is_about_looking_and_stopping(browser: Browser, tmp_path: Path) -> None:
    free_environment()
    server = TestServer(tmp_path, "tcp/127.0.0.1:9")
    try:
        with browser.new_context() as context:
            page = context.new_page()
            page.goto(f"{server.url}/?token={VIEWER_TOKEN}")
            guide = page.get_by_test_id("guide")
            for number, title in enumerate(("Watch", "Stop", "Look back"), 1):
                expect(guide).to_contain_text(f"{number} of 3: {title}")
                assert "Arm" not in guide.inner_text()
                shot(page, f"viewer-guide-{number}")
                page.get_by_test_id("guide-next").click()
            expect(guide).to_have_count(0)
            page.reload()
            expect(page.get_by_test_id("e-stop")).to_be_visible()
            expect(guide).to_have_count(0)
    finally:
        server.close()
