"""A real browser in which the target is dragged, where playwright and a chromium are installed."""

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from controller.errors import TendrilError
from server.app.browser import launch_chromium
from server.campaign.waiting import Skipped, require

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

READY = 60_000
"""For the page [ms]."""
FIRST_VISIT = "localStorage.setItem('tendril-guide', 'seen'); localStorage.setItem('tendril-3d', 'closed')"


@contextlib.contextmanager
def a_browser() -> "Iterator[Browser]":
    """A chromium of its own; `Skipped` without one. It may be killed."""
    launched = contextlib.ExitStack()
    try:
        browser = launched.enter_context(launch_chromium())
    except TendrilError as error:
        raise Skipped(str(error)) from error
    try:
        yield browser
    finally:
        with contextlib.suppress(Exception):  # it may be dead by now
            launched.close()


@contextlib.contextmanager
def operating_page(url: str) -> "Iterator[Page]":
    """A page in a chromium of its own that holds the lease; `Skipped` without a browser. The browser may be killed."""
    with a_browser() as browser:
        page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
        page.add_init_script(FIRST_VISIT)
        page.goto(url)
        page.get_by_test_id("lease-take").click(timeout=READY)
        yield page


def press_and_move(page: "Page") -> None:
    """Press the mouse on the target, move it, and keep it down."""
    x, y = page.evaluate("window.__tendril.handle()")
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(x - 2 * step, y - 3 * step)
        page.wait_for_timeout(30)


def kill_browser() -> None:
    """End every chromium that descends from this process, as a crash does."""
    found = [process for process in map(_parsed, Path("/proc").glob("[0-9]*/status")) if process]
    parents = {process: parent for process, parent, _ in found}
    ours = [process for process, _, name in found if "chrom" in name and _descends(process, parents)]
    require(ours, "the browser's process was not found")
    for process in ours:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)


def _parsed(path: Path) -> tuple[int, int, str] | None:
    """Process, its parent, and its name."""
    try:
        lines = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    except OSError:
        return None
    return int(path.parent.name), int(lines["PPid"]), lines["Name"]


def _descends(process: int, parents: dict[int, int]) -> bool:
    while process > 1:
        process = parents.get(process, 0)
        if process == os.getpid():
            return True
    return False
