"""A page that is busy is present, one that is gone is not: a real chromium and the rig's own ring."""

import time

import psutil
import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.modes import Cause, Mode
from tests.e2e.hand import Hand, arm
from tests.e2e.product import OPERATOR_TIMEOUT_S, Product, frame, open_page, wait_until
from tests.e2e.tab import end_session

BUSY = "(ms) => { const end = performance.now() + ms; while (performance.now() < end); }"
"""The main thread does nothing else for so long."""
GONE_MAX_NS = 1e9 * (OPERATOR_TIMEOUT_S + 1.5)
"""A page that is gone is held for its missing signs, and no longer."""


@pytest.fixture
def hand(page: Page, product: Product) -> Hand:
    """A drag that goes on."""
    arm(page)
    found = Hand(page, product)
    found.press()
    found.move(-20, -30)
    found.wait(Mode.FOLLOW)
    return found


def test_a_main_thread_that_is_busy_for_two_seconds_ends_no_drag(page: Page, hand: Hand) -> None:
    start = time.monotonic_ns()
    for _ in range(2):
        page.evaluate(BUSY, 2000)
        page.wait_for_timeout(100)
    rows = hand.rows(start)
    assert rows["t_ns"][-1] - start > 4_000_000_000
    assert (rows["mode"] == Mode.FOLLOW).all(), [Cause(cause).name for cause in set(rows["cause"].tolist())]
    before = hand.settled()
    hand.move(-5, 0)
    wait_until(lambda: hand.target()[0] < before[0])
    hand.up()
    page.get_by_test_id("lease-release").click()


def test_a_main_thread_that_is_busy_for_two_seconds_ends_no_run(page: Page, product: Product) -> None:
    arm(page)
    page.get_by_role("tab", name="Run").click()
    page.evaluate("""async () => {
        const asked = await fetch('/api/run', { method: 'POST', headers: { 'content-type': 'application/json' },
          body: JSON.stringify({ reference: 'circle_1hz', laps: null, record: false }) });
        if (!asked.ok) throw new Error(await asked.text()); }""")
    wait_until(lambda: frame(page)["mode"] == Mode.TRACK)
    start = time.monotonic_ns()
    page.evaluate(BUSY, 2000)
    page.wait_for_timeout(500)
    rows = Hand(page, product).rows(start)
    assert (rows["mode"] == Mode.TRACK).all(), [Cause(cause).name for cause in set(rows["cause"].tolist())]
    page.get_by_role("tab", name="Control").click()
    page.get_by_test_id("hold").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_test_id("lease-release").click()


def test_a_main_thread_that_hangs_ends_a_drag_while_it_hangs(page: Page, hand: Hand) -> None:
    start = time.monotonic_ns()
    page.evaluate(
        "(ms) => setTimeout(() => { const end = performance.now() + ms; while (performance.now() < end); })", 9000
    )
    hand.wait(Mode.HOLD)
    held = hand.rows(start)
    first = held[held["mode"] == Mode.HOLD][0]
    assert first["cause"] == Cause.OPERATOR_LOST
    assert 1.9e9 < first["t_ns"] - start < 8e9, "it had patience, and not without end"
    page.evaluate("1")  # it is back
    page.wait_for_timeout(1000)
    rows = hand.rows(int(first["t_ns"]))
    assert (rows["mode"] == Mode.HOLD).all(), "coming back moves nothing"
    hand.up()


@pytest.mark.parametrize("way", ["gone to another page", "closed"])
def test_a_page_that_is_gone_ends_a_drag(way: str, page: Page, hand: Hand) -> None:
    start = time.monotonic_ns()
    if way == "closed":
        page.close()
    else:
        page.goto("about:blank")
    hand.wait(Mode.HOLD)
    rows = hand.rows(start)
    first = rows[rows["mode"] == Mode.HOLD][0]
    assert first["cause"] in (Cause.OPERATOR_LOST, Cause.OPERATOR), "its last word may be to hold"
    assert first["t_ns"] - start < GONE_MAX_NS, "long before its patience for a busy page"


def test_a_page_that_is_stopped_ends_a_drag_and_waking_moves_nothing(page: Page, hand: Hand) -> None:
    """As a frozen tab or a sleeping laptop is: main thread and worker stand still, and every socket stays open."""
    stopped = [one for one in psutil.Process().children(recursive=True) if "--type=renderer" in one.cmdline()]
    assert stopped
    start = time.monotonic_ns()
    try:
        for renderer in stopped:
            renderer.suspend()
        hand.wait(Mode.HOLD)
        rows = hand.rows(start)
        first = rows[rows["mode"] == Mode.HOLD][0]
        assert first["cause"] == Cause.OPERATOR_LOST
        assert first["t_ns"] - start < GONE_MAX_NS
    finally:
        for renderer in stopped:
            renderer.resume()
    page.wait_for_timeout(1000)
    assert (hand.rows(int(first["t_ns"]))["mode"] == Mode.HOLD).all()
    hand.up()


def test_two_tabs_have_one_live_socket_each_and_the_closed_ones_presence_ends(
    browser: Browser, product: Product
) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    first, second = open_page(context, product), open_page(context, product)
    arm(first)
    hand = Hand(first, product)
    hand.press()
    hand.move(-5, -5)
    hand.wait(Mode.FOLLOW)
    assert second.evaluate("() => fetch('/api/health').then((a) => a.json())")["viewers"] == 2
    first.close()
    hand.wait(Mode.HOLD)
    end_session(context)
