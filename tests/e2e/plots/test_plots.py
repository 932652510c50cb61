"""What an operator does with the plots: read at the cursor, stop, zoom, take a file, choose signals, come back."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, CDPSession, Page, expect

from tests.e2e.product import Product, open_page, shot, wait_until
from tests.e2e.tab import end_session

pytestmark = pytest.mark.keyed("frontend/src", "server/plots", "tests/e2e/*.py", imports=False)

FIGURE = re.compile("\\d|error\\|\N{EN DASH}")
"""Of a readout; vented, there is no reference, and no error."""


def saved(page: Page) -> tuple[str, list[float]]:
    """What the CSV of the plots says about itself, and its times [s on the rig's clock]."""
    with page.expect_download() as download:
        page.get_by_test_id("csv").click()
    lines = Path(download.value.path()).read_text().splitlines()
    return lines[1], [float(line.split(",")[0]) for line in lines[3:]]


def touch(cdp: CDPSession, *steps: list[tuple[float, float]]) -> None:
    """Put fingers down at the first places, move them to the others, lift them."""
    for kind, places in zip(["touchStart", *["touchMove"] * (len(steps) - 1), "touchEnd"], [*steps, []], strict=True):
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        cdp.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_signals_are_read_stopped_zoomed_saved_and_chosen(page: Page) -> None:
    readout, plots = page.get_by_test_id("readout").first, page.get_by_role("region", name="Plots")
    wait_until(lambda: page.evaluate("window.__tendril.frames") > 60)
    box = page.locator(".chart-host .u-over").first.bounding_box()
    assert box
    left, middle, y = box["x"] + 0.8 * box["width"], box["x"] + 0.97 * box["width"], box["y"] + 0.8 * box["height"]
    page.mouse.move(left, y)
    expect(readout).to_contain_text("measured tip")
    streaming = readout.inner_text()
    wait_until(lambda: readout.inner_text() != streaming)
    page.get_by_test_id("pause").click()
    page.mouse.move(left, y)
    stopped = readout.inner_text()
    for line in ("measured tip", "observer tip", "reference"):
        assert line in stopped
    page.mouse.down()
    page.mouse.move(middle, y, steps=3)
    page.mouse.up()
    shot(page, "plots-zoom")
    said, times = saved(page)
    assert "every tick" in said
    assert 1.2 < times[-1] - times[0] < 2.2, "17 % of 10 s"
    assert len(times) > 800 * (times[-1] - times[0]), "1 kHz, perhaps with some ticks lost"
    page.mouse.dblclick(left, y)
    expect(plots).to_have_attribute("data-stopped", "true")
    page.get_by_test_id("pause").click()
    expect(plots).to_have_attribute("data-stopped", "false")
    page.get_by_test_id("add-plot").click()
    page.get_by_role("combobox", name="Signals").fill("torque 2")
    with page.expect_response(lambda answer: "u_fb" in (answer.request.post_data or "")):  # not that of the empty plot
        page.get_by_role("option", name="feedback torque u2").click()
    shot(page, "plots-chooser")
    page.reload()
    expect(page.get_by_test_id("chart")).to_have_count(5)
    expect(page.get_by_role("figure", name="feedback torque u2 over time")).to_be_visible()


def test_plots_have_one_cursor_and_the_time_once_under_each_column(page: Page) -> None:
    wait_until(lambda: page.evaluate("window.__tendril.frames") > 60)
    for size, columns in (((1280, 720), 4), ((820, 1180), 2)):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        axes = page.get_by_test_id("time-axis")
        expect(axes).to_have_count(columns)
        expect(axes.first).to_contain_text("0 s")
        charts, under = (
            {each["x"] for one in found.all() if (each := one.bounding_box())}
            for found in (page.get_by_test_id("chart"), axes)
        )
        assert charts == under
        over = page.locator(".chart-host .u-over").nth(1).bounding_box()
        assert over
        page.mouse.move(over["x"] + 0.5 * over["width"], over["y"] + 0.5 * over["height"])
        for readout in page.get_by_test_id("readout").all():
            expect(readout).to_have_text(FIGURE)
        page.get_by_test_id("pause").dispatch_event("click")  # else the times change while they are read
        times = page.get_by_test_id("cursor-time").all_inner_texts()
        assert len(times) == columns
        assert len(set(times)) == 1
        assert -5.5 < float(times[0].removesuffix(" s")) < -4.5, "in the middle of 10 s"
        shot(page, f"plots-cursor-{columns}")
        page.get_by_test_id("pause").dispatch_event("click")


def test_one_finger_drags_the_time_two_stretch_it_and_a_tap_only_reads(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, has_touch=True)
    page = open_page(context, product)
    cdp, plots = context.new_cdp_session(page), page.get_by_role("region", name="Plots")
    box = page.locator(".chart-host .u-over").first.bounding_box()
    assert box
    y = box["y"] + 0.5 * box["height"]
    at = [box["x"] + share / 10 * box["width"] for share in range(11)]
    wait_until(lambda: page.evaluate("window.__tendril.frames") > 60)
    page.touchscreen.tap(at[9], y)
    expect(page.get_by_test_id("readout").first).to_contain_text("measured tip")
    expect(plots).to_have_attribute("data-stopped", "false")

    touch(cdp, [(at[5], y)], [(at[6], y)], [(at[7], y)])
    expect(plots).to_have_attribute("data-stopped", "true")
    stopped = saved(page)[1][-1]
    touch(cdp, [(at[5], y)], [(at[6], y)], [(at[7], y)])
    before = saved(page)[1][-1]
    assert 1.9 < stopped - before < 2.1, "a finger takes 2 of 10 s along"
    touch(cdp, [(at[4], y), (at[6], y)], [(at[3], y), (at[7], y)], [(at[1], y), (at[9], y)])
    shot(page, "plots-pinched")
    wait_until(lambda: saved(page)[1])  # of another span nothing is there before the server has sent it
    times = saved(page)[1]
    assert before - 4.3 < times[-1] < before - 3.3, "2.5 s about the middle of what was shown"
    assert times[-1] - times[0] < 2.7
    page.get_by_test_id("pause").click()
    expect(plots).to_have_attribute("data-stopped", "false")
    end_session(context)
