"""Bookmarks: set by key and button while something is recorded, drawn in the plots, found again in Review."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from recordings.format.messages import Bookmark
from recordings.store.edits import with_bookmark
from recordings.store.store import Store
from tests.e2e.edge import ask
from tests.e2e.product import shot, wait_until
from tests.e2e.recorded import record_circle
from tests.server.live_server import VIEWER_TOKEN, TestServer, free_environment

pytestmark = pytest.mark.keyed("frontend/src", "server/recorder", "recordings", "tests/e2e/*.py", imports=False)

INKED = """(canvas) => {
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const columns = new Array(width).fill(0);
  const labels = Math.floor(height / 3);
  for (let i = labels * width; i < width * height; i++)
    if (Math.abs(data[4 * i] - 230) + Math.abs(data[4 * i + 1] - 232) + Math.abs(data[4 * i + 2] - 234) < 30)
      columns[i % width] += 1;
  return columns.map((count) => count / (height - labels));
}"""
"""Share of each column of pixels, below the labels, that has the colour of the lines, in the dark: the stem of a letter
is none."""
NEWEST_LABELS = """async () => {
  const [newest] = await (await fetch("/api/recordings")).json();
  return newest.bookmarks.map(({ label }) => label);
}"""
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Two frames later: no one's next press comes sooner."""


@pytest.fixture
def operator(page: Page) -> Iterator[Page]:
    """The page operates, and records; in the dark, whose ink is looked for."""
    page.emulate_media(color_scheme="dark")
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    expect(page.get_by_test_id("lease-release")).to_be_visible()  # before it knows, a key does nothing
    expect(page.get_by_test_id("record")).to_contain_text("Record")  # nor, or the opposite, while another one ends
    page.get_by_test_id("plan").focus()
    page.keyboard.press("r")
    expect(page.get_by_test_id("mark-button")).to_be_enabled()
    yield page
    ask(page, "DELETE", "/api/recordings/current")
    ask(page, "DELETE", "/api/lease")


def lines(canvas: Locator) -> int:
    """How many bookmarks are drawn: columns that are dotted in their colour from top to bottom."""
    share = np.array(canvas.evaluate(INKED))
    return int(np.sum(np.diff(np.concatenate([[0], share > 0.12])) == 1))


def test_a_bookmark_is_set_by_key_named_by_typing_and_found_again(operator: Page) -> None:
    operator.get_by_test_id("window").select_option("60")
    operator.get_by_test_id("plan").focus()
    operator.keyboard.press("b")
    label = operator.get_by_test_id("mark-label")
    expect(label).to_be_focused()
    label.press_sequentially("barely touched")  # its b is typed, and marks nothing
    label.press("Enter")
    expect(label).to_be_hidden()
    operator.wait_for_timeout(3000)  # 15 columns in a plot of a minute: lines that are 2 apart are one
    operator.get_by_test_id("mark-button").click()
    operator.get_by_test_id("mark-label").press("Enter")
    wait_until(lambda: lines(operator.get_by_test_id("chart").first.locator("canvas")) == 2)
    shot(operator, "bookmarks-live")
    operator.get_by_test_id("record").click()
    operator.get_by_text("Review", exact=True).click()
    row = operator.get_by_test_id("recording").first
    expect(row.get_by_text("2 bookmarks", exact=True)).to_be_visible()
    row.click()
    plot = operator.get_by_test_id("quick-plot").first
    expect(plot).to_be_visible()
    wait_until(lambda: lines(plot.locator("canvas")) == 2)
    labels = operator.get_by_test_id("bookmark-label")
    expect(labels.first).to_have_value("barely touched")
    shot(operator, "bookmarks-review")
    labels.last.fill("let go")
    labels.last.press("Enter")
    operator.get_by_test_id("bookmark-remove").first.click()
    expect(labels).to_have_count(1)
    expect(labels).to_have_value("let go")
    operator.get_by_test_id("bookmark-seek").click()
    operator.evaluate(DRAWN)
    at = float(operator.get_by_test_id("bookmark-seek").inner_text().split()[0])
    operator.get_by_test_id("export").click()
    start = float(operator.get_by_test_id("export-from").input_value() or 0)
    assert start < at and at - start <= 2.01, "the plots went to the place"
    operator.reload()
    expect(operator.get_by_test_id("bookmark-label")).to_have_value("let go")


def test_a_label_is_typed_to_its_end_though_the_recording_ends_meanwhile(operator: Page) -> None:
    operator.get_by_test_id("plan").focus()
    operator.keyboard.press("b")
    label = operator.get_by_test_id("mark-label")
    expect(label).to_be_focused()
    operator.keyboard.type("firm ")
    assert ask(operator, "DELETE", "/api/recordings/current")
    expect(operator.get_by_test_id("record")).to_contain_text("Record")
    operator.keyboard.type("rough grip")  # an r outside of the field records
    expect(label).to_have_value("firm rough grip")
    operator.keyboard.press("Enter")
    expect(label).to_be_hidden()
    expect(operator.get_by_test_id("record-profile")).to_be_visible()
    wait_until(lambda: operator.evaluate(NEWEST_LABELS) == ["firm rough grip"])


def test_a_viewer_sees_bookmarks_and_may_change_none(browser: Browser, tmp_path: Path) -> None:
    free_environment()
    done = record_circle(tmp_path / "recordings", "marked", 3.0)
    mark = Bookmark(n=1, tick=1500, t=1.5, label="touched")
    Store(tmp_path / "recordings").revise(done.id, lambda found: with_bookmark(found, mark))
    server = TestServer(tmp_path, "tcp/127.0.0.1:9")
    try:
        with browser.new_context() as context:
            page = context.new_page()
            page.goto(f"{server.url}/?token={VIEWER_TOKEN}#review/{done.id}")
            label = page.get_by_test_id("bookmark-label")
            expect(label).to_have_value("touched")
            expect(label).not_to_be_editable()
            expect(page.get_by_test_id("bookmark-remove")).to_be_disabled()
    finally:
        server.close()
