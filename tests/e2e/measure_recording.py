"""Measures what a long recording costs with three browsers on, and prints JSON. Needs a quiet machine.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.measure_recording`. The twin follows a circle until
stopped, one page operates, two watch. Before, during and after the recording, each `WINDOW` seconds: the p99 of the
rig's lateness and the ticks that it lost (its own ring), and the server's processor time. What the recorder costs is
the server's share of a core with it less that without it: rerun's threads are in it too.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
from playwright.sync_api import BrowserContext, Page, expect

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from recordings.format.messages import Recording
from server.app.browser import launch_chromium
from tests.e2e.product import Product, open_page

VIEWERS = 2
WINDOW = 20.0
"""[s]; the rig's ring holds 32 s."""
WARM = 10.0
"""Before the first window [s]."""


class Window(NamedTuple):
    """What was seen in one window."""

    lateness_p99_us: float
    lost: int
    server_core: float
    """Processor time over time."""
    tracked: float
    """Share of the ticks in which the run went on: a machine that stalls makes the rig hold."""


def operate(page: Page, product: Product) -> None:
    """Let the twin follow a circle until stopped."""
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    post(page.context, product, "run", {"reference": "circle_0.25hz", "laps": None, "record": False})
    expect(page.get_by_test_id("state")).to_contain_text("TRACK")


def post(context: BrowserContext, product: Product, path: str, body: dict[str, Any]) -> None:
    """POST `body` as that page's user."""
    answer = context.request.post(f"{product.origin}/api/{path}", data=body)
    assert answer.ok, answer.text()


def windows(product: Product, count: int) -> list[Window]:
    """The next `count` windows, one after the other."""
    ring, server = find_ring(product.rig), product.child("server.app")
    found = []
    for _ in range(count):
        head, used, start = ring.head, spent(server), time.monotonic()
        time.sleep(WINDOW)
        share = (spent(server) - used) / (time.monotonic() - start)
        _, rows = ring.read(head, ring.head - head)
        lost = int(rows["lost"][-1]) - int(rows["lost"][0])
        tracked = float(np.mean(rows["mode"] == Mode.TRACK))
        found.append(Window(float(np.percentile(rows["lateness_ns"], 99)) / 1e3, lost, share, tracked))
    return found


def spent(process: psutil.Process) -> float:
    """Processor time of a process so far [s]."""
    times = process.cpu_times()
    return float(times.user + times.system)


def record(context: BrowserContext, product: Product, profile: str, count: int) -> tuple[Recording, list[Window]]:
    """A recording of `count` windows, and what was seen in them."""
    post(context, product, "recordings", {"name": "measured", "profile": profile})
    seen = windows(product, count)
    answer = context.request.delete(f"{product.origin}/api/recordings/current")
    assert answer.ok, answer.text()
    return Recording.model_validate_json(answer.body()), seen


def summary(seen: list[Window]) -> dict[str, Any]:
    """Median and range of each figure."""
    columns = {name: [getattr(window, name) for window in seen] for name in Window._fields}
    return {
        name: {"median": round(float(np.median(of)), 3), "min": round(min(of), 3), "max": round(max(of), 3)}
        for name, of in columns.items()
    }


def main() -> None:
    """Measure and print."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--minutes", type=float, default=10.0, help="length of the recording")
    asked.add_argument("--profile", choices=["full", "standard"], default="standard")
    options = asked.parse_args()
    count = max(1, round(options.minutes * 60.0 / WINDOW))
    with tempfile.TemporaryDirectory() as folder, launch_chromium() as browser, Product(Path(folder)) as product:
        operator, *viewers = (browser.new_context() for _ in range(1 + VIEWERS))
        pages = [open_page(context, product) for context in (operator, *viewers)]
        operate(pages[0], product)
        time.sleep(WARM)
        before = windows(product, max(1, count // 5))
        done, during = record(operator, product, options.profile, count)
        time.sleep(WARM)
        after = windows(product, max(1, count // 5))
    off, on = summary(before + after), summary(during)
    cost = on["server_core"]["median"] - off["server_core"]["median"]
    figures = {"rows": done.rows, "seconds": done.seconds, "gaps": done.gaps, "recorder_core": round(cost, 4)}
    print(json.dumps(figures | {"off": off, "on": on}, indent=2))


if __name__ == "__main__":
    main()
