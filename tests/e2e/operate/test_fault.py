"""The rig faults by itself or is killed: what the page says, what it lets an operator do, and the way out."""

import os
import re
import signal

import pytest
from playwright.sync_api import Browser, Page, expect

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.tab import end_session


def dashboard(browser: Browser, product: Product) -> Page:
    """A person's page in a profile of its own."""
    context = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="dark")
    return open_page(context, product)


def lose_samples(page: Page, before: int, percent: int) -> None:
    """Inject the loss of this share of the twin's samples, as an operator does it who sees what is in force."""
    page.get_by_role("tab", name="Sensing").click()
    expect(page.get_by_test_id("fault-sample_loss")).to_have_value(str(before))
    page.get_by_test_id("fault-sample_loss").fill(str(percent))
    with page.expect_response(lambda answer: answer.url.endswith("/faults") and answer.request.method != "GET"):
        page.get_by_test_id("fault-sample_loss").press("Enter")
    page.get_by_role("tab", name="Control").click()


def test_a_rig_that_sees_no_marker_faults_and_the_page_leads_out_of_it(browser: Browser, product: Product) -> None:
    viewer, page = dashboard(browser, product), dashboard(browser, product)
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    lose_samples(page, 0, 100)
    expect(page.get_by_role("status", name="State: FAULT")).to_be_visible()
    expect(page.get_by_test_id("cause")).to_have_text("no measurement")
    expect(page.get_by_role("alert")).to_contain_text(
        "FAULT: the rig went to rest by itself (no measurement). "
        "Check camera, markers and injected faults, then press Clear fault, and arm again."
    )
    for name in ("Arm", "Follow", "Hold", "Disarm"):
        control = page.get_by_test_id(name.lower())
        expect(control).to_be_disabled()
        expect(control).to_have_accessible_description("Clear first")
    shot(page, "fault-dark")
    page.get_by_role("button", name="Light colours").click()
    shot(page, "fault-light")
    expect(viewer.get_by_role("alert")).to_contain_text(re.compile(r"\w+ \w+ \d\d operates and can clear it"))
    expect(viewer.get_by_test_id("clear-latch")).to_have_accessible_description(re.compile(r"\w+ \w+ \d\d operates"))
    shot(viewer, "fault-viewer")

    lose_samples(page, 100, 0)
    page.get_by_test_id("clear-latch").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    expect(page.get_by_role("alert")).to_have_count(0)
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_role("tab", name="Log").click()
    expect(page.get_by_test_id("log")).to_contain_text("rig: FAULT (measurement lost)")
    page.get_by_test_id("lease-release").click()
    end_session(viewer.context)
    end_session(page.context)


@pytest.mark.alone  # its times are for a machine that runs one product
def test_a_killed_rig_is_noticed_and_comes_back_vented(page: Page, product: Product) -> None:
    page.get_by_test_id("lease-take").click()
    if frame(page)["mode"] == Mode.VENTED:
        page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    boot = find_ring(product.rig).boot
    os.kill(product.child("controller.realtime").pid, signal.SIGKILL)
    wait_until(lambda: page.get_by_test_id("banner").count() > 0, 1.0)
    shot(page, "rig-gone")
    wait_until(lambda: find_ring(product.rig).boot != boot, 3.0)
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    expect(page.get_by_test_id("banner")).to_have_count(0)
    assert frame(page)["tick"] < 60_000
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_test_id("lease-release").click()
