"""What an operator does with the plots: read at the cursor, stop, zoom, take a file, choose signals, come back."""

from pathlib import Path

from playwright.sync_api import Page, expect

from tests.e2e.product import shot, wait_until


def test_signals_are_read_stopped_zoomed_saved_and_chosen(page: Page) -> None:
    readout, plots = page.get_by_test_id("readout").first, page.get_by_role("region", name="Plots")
    page.get_by_test_id("toggle-3d").click()  # drawn in software it would only slow this test down
    wait_until(lambda: page.evaluate("window.__tendril.frames") > 60, 10.0)
    box = page.locator(".chart-host .u-over").first.bounding_box()
    assert box
    left, middle, y = box["x"] + 0.8 * box["width"], box["x"] + 0.97 * box["width"], box["y"] + 0.8 * box["height"]
    page.mouse.move(left, y)
    expect(readout).to_contain_text("mm")
    streaming = readout.inner_text()
    wait_until(lambda: readout.inner_text() != streaming, 5.0)
    page.get_by_test_id("pause").click()
    page.mouse.move(left, y)
    stopped = readout.inner_text()
    for line in ("measured tip", "observer tip", "reference"):
        assert line in stopped
    page.mouse.down()
    page.mouse.move(middle, y, steps=3)
    page.mouse.up()
    shot(page, "plots-zoom")
    with page.expect_download() as download:
        page.get_by_test_id("csv").click()
    said = Path(download.value.path()).read_text().splitlines()
    times = [float(line.split(",")[0]) for line in said[3:]]
    assert "every tick" in said[1]
    assert 1.2 < times[-1] - times[0] < 2.2, "17 % of 10 s"
    assert len(times) > 800 * (times[-1] - times[0]), "1 kHz, perhaps with some ticks lost"
    page.mouse.dblclick(left, y)
    expect(plots).to_have_attribute("data-stopped", "true")
    page.get_by_test_id("pause").click()
    expect(plots).to_have_attribute("data-stopped", "false")
    page.get_by_test_id("add-plot").click()
    page.get_by_role("combobox", name="Signals").fill("torque 2")
    with page.expect_response(lambda answer: answer.request.method == "PUT"):
        page.get_by_role("option", name="feedback torque 2").click()
    shot(page, "plots-chooser")
    page.reload()
    expect(page.get_by_test_id("chart")).to_have_count(5, timeout=20_000)
    expect(page.get_by_role("figure", name="feedback torque 2 over time")).to_be_visible()
