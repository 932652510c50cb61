"""Signals: rerun's viewer with a recording in it, opened at once or started hidden while the quick look is read."""

import re

import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from recordings.format.messages import Recording
from tests.e2e.hand import arm, begin_circle
from tests.e2e.product import Product, open_page, pixels_of, shot, wait_until
from tests.e2e.recorded import record_circle

pytestmark = pytest.mark.keyed(
    "frontend/src/recorder", "server/recorder", "recordings", "tests/e2e/*.py", imports=False
)
"""The viewer of a library beside ours takes a minute to start and to draw in software."""

OBSERVER_BLUE = (0x56, 0xB4, 0xE9)
STRETCHES = "async (id) => (await (await fetch(`/api/recordings/${id}/quick`)).json()).stretches"
STATE = "async () => [...(await _handle.viewer_control(new Uint8Array([26, 0])))]"
"""rerun's own answer to GetViewerState, as bytes."""


@pytest.fixture(scope="module")
def made(product: Product) -> Recording:
    return record_circle(product.recordings, "Seen in rerun", 8.0)


@pytest.fixture
def asked(page: Page) -> list[str]:
    """What is asked for from here on: the viewer's page, its program, data."""
    found: list[str] = []

    def note(request: Request) -> None:
        if kind := re.search(r"/rerun/\?|\.wasm|\.rrd", request.url.split("&")[0]):
            found.append(kind[0])

    page.on("request", note)
    return found


@pytest.mark.long
def test_signals_show_at_once_without_a_quick_look_before(page: Page, made: Recording, asked: list[str]) -> None:
    open_recording(page, made)
    sight(page, "Signals")
    curves_stand(page)
    shot(page, "signals")
    assert asked.count("/rerun/?") == 1, "the viewer starts once"


@pytest.mark.long
def test_the_viewer_is_ready_behind_the_quick_look_opens_when_shown_and_hears_esc(
    page: Page, made: Recording, asked: list[str]
) -> None:
    open_recording(page, made)
    notes, frame = page.get_by_test_id("recording-notes"), page.get_by_test_id("viewer")
    notes.fill("the valve sticks")
    expect(frame).to_have_attribute("data-ready", "true")
    expect(frame).to_have_attribute("data-shown", "false")
    expect(notes).to_be_focused()  # who writes goes on
    shot(page, "signals-started-behind")
    assert asked == ["/rerun/?", ".wasm"], "no data are read ahead"
    sight(page, "Signals")
    expect(frame).to_have_attribute("data-shown", "true")
    curves_stand(page)
    assert asked == ["/rerun/?", ".wasm", ".rrd"]
    sight(page, "Quick")
    expect(page.get_by_test_id("quick-plot").first).to_be_visible()
    sight(page, "Signals")
    curves_stand(page)
    assert asked == ["/rerun/?", ".wasm", ".rrd"], "it stayed as it was"
    esc_is_heard(page)
    page.get_by_test_id("back").click()
    expect(frame).to_have_count(0)


def test_a_viewer_at_rest_opens_what_it_is_told_without_anything_that_moves(
    page: Page, product: Product, made: Recording, asked: list[str]
) -> None:
    page.goto(f"{product.origin}/rerun/?hide_welcome_screen&persist=0")
    wait_until(lambda: page.evaluate("!!window._handle"))
    page.wait_for_timeout(3000)  # its first frames are drawn
    url = f"{product.origin}/api/recordings/{made.id}.rrd"
    page.evaluate("(url) => postMessage({ tendril: 'open', url }, location.origin)", url)
    wait_until(lambda: page.wait_for_timeout(100) or ".rrd" in asked)


@pytest.mark.long
def test_a_viewer_that_nobody_looks_at_is_let_go(context: BrowserContext, product: Product, made: Recording) -> None:
    context.clock.install()
    page = open_page(context, product)
    open_recording(page, made)
    frame = page.get_by_test_id("viewer")
    expect(frame).to_have_count(1)
    context.clock.fast_forward(121_000)
    expect(frame).to_have_count(0)
    sight(page, "Signals")
    expect(frame).to_have_attribute("data-ready", "true")


def open_recording(page: Page, recording: Recording) -> None:
    page.evaluate("(hash) => { location.hash = hash; }", f"#review/{recording.id}")
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)


def sight(page: Page, name: str) -> None:
    page.get_by_test_id("sight").get_by_text(name, exact=True).click()


def esc_is_heard(page: Page) -> None:
    """Pressed in the viewer it reaches our page, which holds the motion."""
    page.evaluate(
        """() => addEventListener("message", ({ data }) => { if (data.tendril === "escape") window.heard = true; })"""
    )
    page.get_by_test_id("viewer").click(position={"x": 300, "y": 5})
    page.keyboard.press("Escape")
    wait_until(lambda: page.evaluate("window.heard === true"))


def curves_stand(page: Page) -> None:
    """The viewer's plots, in its right half, have their curves."""
    expect(page.get_by_test_id("quick")).to_have_count(0)
    box = page.get_by_test_id("viewer").bounding_box()
    assert box
    curves = {**box, "x": box["x"] + 0.45 * box["width"], "width": 0.5 * box["width"]}
    wait_until(lambda: len(pixels_of(page, OBSERVER_BLUE, curves)) > 100)


def follow_circle(page: Page) -> None:
    """To its end."""
    begin_circle(page)
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")


def test_the_cursor_stands_where_the_run_begins(page: Page) -> None:
    arm(page)
    follow_circle(page)
    page.get_by_test_id("run-recording").click()
    expect(page.get_by_test_id("quick-plot").first).to_be_visible()
    course = page.evaluate(STRETCHES, page.url.split("/")[-1])
    [begin, *_] = [stretch["start"] for stretch in course if stretch["kind"] == "run"]
    assert begin > 1.0, "before it are what was kept from before, and the approach"
    sight(page, "Signals")
    curves_stand(page)
    viewer = next(frame for frame in page.frames if "/rerun/" in frame.url)
    wait_until(lambda: varint(round(begin * 1e9)) in bytes(viewer.evaluate(STATE)))


def varint(value: int) -> bytes:
    """As protobuf writes it."""
    return bytes([value]) if value < 128 else bytes([value & 127 | 128]) + varint(value >> 7)
