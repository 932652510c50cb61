"""The server killed or frozen under the operator's hands: what rig and recording do, and what the page says."""

import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import psutil
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from recordings.read.reader import read_rows
from tests.e2e.product import Product, frame, open_page, shot, wait_until

pytestmark = pytest.mark.alone


@pytest.fixture(scope="module")
def product(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Product]:
    """One of its own: no other test should see what is left of it."""
    with Product(tmp_path_factory.mktemp("product")) as running:
        yield running


@pytest.mark.long  # tests/server/recorder/test_automatic.py and the campaign show the same without a browser
def test_a_killed_server_leaves_the_rig_at_rest_and_no_tick_of_the_recording_is_missing(
    context: BrowserContext, product: Product
) -> None:
    page = open_page(context, product)
    page.get_by_test_id("lease-take").click()
    if frame(page)["mode"] == Mode.VENTED:
        page.get_by_test_id("arm").click()
    page.get_by_test_id("follow").click()
    expect(page.get_by_test_id("state")).to_contain_text("FOLLOW")
    page.get_by_test_id("record").click()
    time.sleep(1.5)
    ring = find_ring(product.rig)
    killed = product.child("server.app")
    last = ring.newest()
    os.kill(killed.pid, signal.SIGKILL)
    wait_until(lambda: product.mode() == Mode.HOLD, 2.0)
    shot(page, "server-gone")
    wait_until(lambda: product.child("server.app").pid != killed.pid)
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    assert last is not None
    wait_until(lambda: recorded(product)[-1] > last["tick"] + 1000)
    assert (np.diff(recorded(product)) == 1).all()


def recorded(product: Product) -> np.ndarray:
    """Ticks in its recordings: the recorder goes on without the server."""
    return np.sort(np.concatenate([read_rows(path)["tick"] for path in product.recordings.glob("*.rrd")]))


def test_control_that_goes_with_the_server_is_said(context: BrowserContext, product: Product) -> None:
    page = open_page(context, product)
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    os.kill(product.child("server.app").pid, signal.SIGKILL)
    expect(page.get_by_test_id("lease")).to_have_attribute("data-mine", "false", timeout=120_000)
    page.get_by_role("tab", name="Log", exact=True).click()
    expect(page.get_by_test_id("log")).to_contain_text("You no longer operate: the server was started again")
    shot(page, "lease-lost")


@pytest.mark.long  # tests/controller/realtime/test_rig.py shows the same of the rig with shorter limits
def test_without_any_server_the_rig_ramps_to_rest(page: Page, product: Product) -> None:
    page.get_by_test_id("lease-take").click()
    if frame(page)["mode"] == Mode.VENTED:
        page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    server = product.child("server.app")
    server.suspend()
    try:
        wait_until(lambda: product.mode() in (Mode.REST, Mode.VENTED), 35.0)
        wait_until(lambda: product.mode() == Mode.VENTED, 10.0)
    finally:
        server.resume()
    assert psutil.pid_exists(server.pid)
