"""The whole page under https: its own socket, viser's and rerun's frames. Chromium takes the certificate on trust."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from tests.e2e.operate.test_operate import PATH_MM, drag
from tests.e2e.plan.test_gizmo import gizmo
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.recorded import record_circle
from tests.e2e.recorder.test_signals import curves_stand, open_recording, sight
from tests.server.certificate import make_pair

pytestmark = pytest.mark.alone


@pytest.fixture(scope="module")
def product(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Product]:
    folder: Path = tmp_path_factory.mktemp("https")
    cert, key = make_pair(folder)
    with Product(folder, "--tls-cert", str(cert), "--tls-key", str(key)) as running:
        yield running


@pytest.fixture
def secure(browser: Browser) -> Iterator[BrowserContext]:
    opened = browser.new_context(viewport={"width": 1280, "height": 720}, ignore_https_errors=True)
    yield opened
    opened.close()


@pytest.mark.long
def test_page_and_frames_work_under_https_and_nothing_goes_around_it(secure: BrowserContext, product: Product) -> None:
    made = record_circle(product.recordings, "Seen under https", 8.0)
    asked: set[str] = set()
    secure.on("request", lambda request: asked.add(request.url.split("://")[0]))
    page = open_page(secure, product, with_3d=True)
    page.on("websocket", lambda socket: asked.add(socket.url.split("://")[0]))
    page.reload()
    wait_until(lambda: page.evaluate("!!window.__tendril?.frame"))
    operate(page)
    wait_until(lambda: gizmo(page))
    shot(page, "https")
    open_recording(page, made)
    sight(page, "Signals")
    curves_stand(page)
    shot(page, "https-signals")
    assert {"https", "wss"} <= asked <= {"https", "wss", "blob:https", "data"}
    [cookie] = [found for found in secure.cookies() if found["name"].startswith(("tendril", "__Host"))]
    assert cookie["secure"]
    assert cookie["httpOnly"]


def operate(page: Page) -> None:
    """Take control, arm and drag the target."""
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    before = frame(page)["target"]
    drag(page, PATH_MM, 2.0)
    wait_until(lambda: frame(page)["target"] != before)
