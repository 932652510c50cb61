"""Lets the product work for long and looks at what it keeps: memory and open files of rig and server. Prints JSON.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.measure_soak --minutes 30`. A real browser goes
round: record, drag the target, draw and run it (which records too), open the newest recording in Review, and back.
Every `EVERY` seconds both processes are looked at; what counts is the growth after `SETTLE` minutes, when every ring
and cache has been filled once: of a line through all samples, and from the median of the first third to the last's.
Requests and files that are read come and go, so the growth of open files is that of the fewest: what is never closed
raises that too. Kinds whose fewest differ are named.
"""

import argparse
import json
import math
import os
import re
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from playwright.sync_api import Page, expect

from server.app.browser import launch_chromium
from tests.e2e.drawing.test_drawing import draw
from tests.e2e.operate.test_operate import PATH_MM, drag
from tests.e2e.product import Product, open_page, wait_until

EVERY, SETTLE = 10.0, 5.0
BARS = {"rss_growth_percent": 3.0, "fd_growth": 0}
RING_MM = [(235.0 - 12.0 * math.cos(s / 6), 60.0 + 12.0 * math.sin(s / 6)) for s in range(38)]


class Sample(NamedTuple):
    """One look at one process."""

    t: float
    """Since the start [s]."""
    rss: float
    """[MB]"""
    fds: Counter[str]
    """Open files of each kind: a path, or what the kernel calls it."""


class Watch:
    """Samples both processes from a thread of its own until it is closed."""

    def __init__(self, product: Product) -> None:
        self._processes = {"rig": product.child("controller.realtime"), "server": product.child("server.app")}
        self.seen: dict[str, list[Sample]] = {name: [] for name in self._processes}
        self._begin, self._over = time.monotonic(), threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(EVERY):
            for name, process in self._processes.items():
                rss, t = process.memory_info().rss / 1e6, time.monotonic() - self._begin
                self.seen[name].append(Sample(t, rss, open_files(process.pid)))

    def close(self) -> None:
        """Look no more."""
        self._over.set()
        self._thread.join()


def open_files(pid: int) -> Counter[str]:
    """How many files of each kind the process has open."""
    kinds: Counter[str] = Counter()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            kinds[re.sub(r":\[\d+\]", "", os.readlink(link))] += 1
        except FileNotFoundError:  # closed this moment
            continue
    return kinds


def growth(samples: list[Sample], settle: float) -> dict[str, Any]:
    """What was kept between `settle` [s] and the end."""
    counted = [sample for sample in samples if sample.t >= settle]
    t, rss = (np.array([getattr(sample, name) for sample in counted]) for name in ("t", "rss"))
    fds = [sample.fds for sample in counted]
    third = max(1, len(t) // 3)
    total = [np.array([sample.total() for sample in part]) for part in (fds[:third], fds[-third:])]
    kinds = {kind: [min(s[kind] for s in part) for part in (fds[:third], fds[-third:])] for kind in set().union(*fds)}
    slope, _ = np.polyfit(t, rss, 1) if len(t) > 1 else (0.0, 0.0)
    first, last = float(np.median(rss[:third])), float(np.median(rss[-third:]))
    return {
        "samples": len(t),
        "rss_first_mb": round(first, 1),
        "rss_last_mb": round(last, 1),
        "rss_growth_percent": round(100.0 * (last - first) / first, 2),
        "rss_line_percent": round(100.0 * slope * (t[-1] - t[0]) / first, 2),
        "fds_first": int(total[0].min()),
        "fd_growth": int(total[1].min() - total[0].min()),
        "fd_median_growth": float(np.median(total[1]) - np.median(total[0])),
        "fd_kinds": {kind: fewest for kind, fewest in kinds.items() if fewest[0] != fewest[1]},
    }


def go_round(page: Page) -> None:
    """Everything once, about half a minute."""
    arm(page)
    page.get_by_test_id("record").click()
    drag(page, PATH_MM, 5.0)
    page.get_by_test_id("record").click()
    page.get_by_test_id("tool-freehand").click()
    draw(page, RING_MM)
    page.get_by_role("tab", name="Run").click()
    page.get_by_text("Drawing", exact=True).first.click()  # the result card says it too
    page.get_by_test_id("timing").select_option("duration")
    page.get_by_test_id("duration").fill("4")
    page.get_by_test_id("run").click(timeout=20_000)
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done", timeout=60_000)
    page.get_by_test_id("clear-drawing").click()
    page.get_by_role("tab", name="Control").click()
    review(page)


def arm(page: Page) -> None:
    """HOLD, whatever was before: a machine that stalls makes the rig let go."""
    if page.get_by_test_id("lease-take").count():
        page.get_by_test_id("lease-take").click()
    if "VENTED" in page.get_by_test_id("state").inner_text():
        page.get_by_test_id("arm").click()
        expect(page.get_by_test_id("state")).to_contain_text("HOLD")


def review(page: Page) -> None:
    """Look at the newest recording, and go back to work."""
    page.get_by_text("Review", exact=True).click()
    page.get_by_test_id("recording").first.click(timeout=20_000)
    expect(page.get_by_test_id("sight")).to_be_visible()
    page.get_by_role("link", name="Recordings").or_(page.get_by_role("button", name="Recordings")).click()
    page.get_by_text("Live", exact=True).click()
    wait_until(lambda: page.get_by_test_id("state").count() > 0, 20.0)


def run(product: Product, page: Page, minutes: float, settle: float) -> dict[str, Any]:
    """Go round until the time is over; a round that fails is counted and told, and the next one begins again."""
    watch, end, rounds, failed = Watch(product), time.monotonic() + 60.0 * minutes, 0, []
    try:
        while time.monotonic() < end:
            try:
                go_round(page)
                rounds += 1
            except Exception as error:
                failed.append(str(error).splitlines()[0])
                page.reload()
                wait_until(lambda: page.evaluate("!!window.__tendril?.frame"), 60.0)
    finally:
        watch.close()
    figures = {name: growth(samples, 60.0 * settle) for name, samples in watch.seen.items()}
    return {"rounds": rounds, "failed": failed, **figures}


def main() -> None:
    """Measure and print."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--minutes", type=float, default=30.0)
    asked.add_argument("--settle", type=float, default=SETTLE, help="minutes that do not count")
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as folder, launch_chromium() as browser, Product(Path(folder)) as product:
        page = open_page(browser.new_context(), product)
        figures = run(product, page, options.minutes, options.settle)
    passed = figures["rounds"] > 0 and all(
        figures[name]["rss_growth_percent"] <= BARS["rss_growth_percent"] and figures[name]["fd_growth"] <= 0
        for name in ("rig", "server")
    )
    print(json.dumps({"figures": figures, "bars": BARS, "pass": passed}, indent=2))


if __name__ == "__main__":
    main()
