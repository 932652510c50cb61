"""How long a recording takes to open in rerun's viewer, and what that costs chromium."""

from contextlib import closing
from typing import NamedTuple

import psutil
from playwright.sync_api import Page, expect

from tests.e2e.screencast import screencast

OBSERVER_BLUE = (0x56, 0xB4, 0xE9)
CLICK = """() => new Promise((say) => {
  const clicked = Date.now() / 1e3;
  document.querySelector("[data-testid=sight] input[value=plots]").click();
  const look = () => {
    const frame = document.querySelector("[data-testid=viewer][data-shown=true]");
    if (!frame || document.querySelector("[data-testid=quick]")) return requestAnimationFrame(look);
    const { x, y, width, height } = frame.getBoundingClientRect();
    say([clicked, Date.now() / 1e3, { x: x + 0.45 * width, y, width: 0.5 * width, height }]);
  };
  look();
})"""
"""Times of the click and of the quick look's end (its curves look alike), and where rerun's plots are."""
PAINTED = 0.1
"""A frame that was under way as the quick look went is on the screen by then [s]."""


class Opening(NamedTuple):
    """One recording opened."""

    seconds: float
    """From the click on Signals to the frame with the first curves."""
    software_s: float
    """Processor time of chromium's graphics process meanwhile: without a graphics card it draws itself."""
    waiting_mb: float
    """Memory of the browser that the viewer behind the quick look has added."""


def in_rerun(page: Page, id: str, read: float) -> Opening:
    """Open `id` on a page just loaded, and its Signals once its quick look has been read for `read` seconds."""
    page.reload()
    page.get_by_test_id("recording-search").fill(id)
    expect(page.locator(f"[data-id='{id}']")).to_be_visible()
    before = memory()
    page.locator(f"[data-id='{id}']").click()
    expect(page.get_by_test_id("quick-plot")).to_have_count(6, timeout=30_000)
    page.wait_for_timeout(1e3 * read)
    waiting = memory() - before
    drawn = drawing()
    clicked, gone, plots = page.evaluate(CLICK)
    seconds = first_curves(page, gone + PAINTED, plots) - clicked
    opening = Opening(seconds, drawing() - drawn, waiting)
    page.get_by_test_id("back").click()
    return opening


def first_curves(page: Page, after: float, plots: dict[str, float]) -> float:
    """Time of the first frame after `after` with curves in the region `plots`; fails after 60 s."""
    with closing(screencast(page)) as frames:
        for frame in frames:
            assert frame.at < after + 60.0, "no curves"
            if frame.at > after and frame.count(OBSERVER_BLUE, plots) > 100:
                return frame.at
    raise AssertionError("frames have no end")


def memory() -> float:
    """What all processes of the browser have for themselves [MB]."""
    return sum(process.memory_full_info().uss for process in chromium()) * 1e-6


def drawing() -> float:
    """Processor time of its graphics process so far [s]."""
    return sum(sum(p.cpu_times()[:2]) for p in chromium() if "--type=gpu-process" in p.cmdline())


def chromium() -> list[psutil.Process]:
    """The browser's processes, which are descendants of this one."""
    return [child for child in psutil.Process().children(recursive=True) if "chrom" in child.name()]
