"""A twin that stands still in the middle of what it does: shown as such, stepped, continued, ended by every stop."""

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from recordings.read.reader import read_rows
from tests.e2e.hand import Hand, arm, begin_circle
from tests.e2e.product import Product, shot, wait_until

pytestmark = pytest.mark.keyed("frontend/src", "server", "controller", "recordings", "tests/e2e/*.py", imports=False)
"""Of the whole product: whatever changes in it, this is tested again."""


def head(product: Product) -> int:
    """Ticks that the rig has taken."""
    return find_ring(product.rig).head


def pause(page: Page, product: Product) -> int:
    """Pause by key; the rig's ticks then."""
    page.locator("body").press("p")
    expect(page.get_by_test_id("state")).to_contain_text("PAUSED")
    return head(product)


def test_a_run_paused_in_the_middle_is_stepped_goes_on_and_is_recorded_without_a_gap(
    page: Page, product: Product
) -> None:
    before = set(product.recordings.glob("*.json"))
    arm(page)
    begin_circle(page)
    ticks = pause(page, product)
    page.get_by_role("tab", name="Control").click()
    page.wait_for_timeout(2500)
    assert head(product) == ticks
    expect(page.get_by_test_id("state")).to_contain_text("PAUSED")
    expect(page.get_by_test_id("primary-continue")).to_be_visible()
    shot(page, "paused-in-a-run")
    page.get_by_test_id("twin-step-length").get_by_text("100 ms").click()
    page.get_by_test_id("twin-step").click()
    wait_until(lambda: head(product) == ticks + 100)
    expect(page.get_by_test_id("state")).to_contain_text("PAUSED")
    page.locator("body").press(".")
    wait_until(lambda: head(product) == ticks + 200)
    expect(page.get_by_test_id("state")).to_contain_text("PAUSED")
    page.get_by_test_id("primary-continue").click()
    page.get_by_role("tab", name="Run").click()
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")
    wait_until(lambda: set(product.recordings.glob("*circle*.json")) - before)
    [recording] = set(product.recordings.glob("*circle*.json")) - before
    rows = read_rows(recording.with_suffix(".rrd"), ["tick", "slot", "t_ns", "p_ref", "mode"])
    assert np.all(np.diff(rows["tick"]) == 1)
    assert np.count_nonzero(np.diff(rows["t_ns"]) > 2e9) == 1, "the pause is seen in the rows' times"
    run = rows["p_ref"][rows["mode"] == Mode.TRACK]
    assert np.linalg.norm(np.diff(run, axis=0), axis=1).max() < 1e-3
    shot(page, "paused-run-done")


def test_esc_holds_a_paused_twin_at_once(page: Page, product: Product) -> None:
    arm(page)
    hand = Hand(page, product)
    hand.press()
    hand.move(20, -20)
    hand.wait(Mode.FOLLOW)
    hand.up()
    pause(page, product)
    page.keyboard.press("Escape")
    hand.wait(Mode.HOLD)
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")


def test_a_paused_twin_goes_on_and_holds_when_its_operator_leaves(page: Page, product: Product) -> None:
    arm(page)
    page.get_by_test_id("follow").click()
    expect(page.get_by_test_id("state")).to_contain_text("FOLLOW")
    ticks = pause(page, product)
    page.close()
    wait_until(lambda: head(product) > ticks and product.mode() not in (Mode.FOLLOW, Mode.TRACK))
