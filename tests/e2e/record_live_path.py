"""Records Task 5's path as an operator makes it: the real product, a real browser, a hand on the plan's target.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.record_live_path`. The hand is a seeded random walk
of overlapping reaching movements with pauses, moved in real time. What is kept is what the rig got: every target of the
server's own recording, at the time of the first tick that had it. Two recordings of one seed differ by their timing.
"""

import argparse
import asyncio
import tempfile
import time
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np
from playwright.async_api import Browser, CDPSession, Page, async_playwright, expect

from controller.arrays import Array
from controller.schema.modes import Mode
from recordings.read.reader import read_rows
from server.app.browser import FLAGS, find_chromium
from tests.e2e.product import Product

OUT = Path("controller/reference/data/live_path.csv")
SEED, SECONDS, ATTEMPTS = 214, 30.0, 6
PERIOD_S = 0.01
"""Time between two moves of the pointer [s]."""
EVEN = 0.015
"""A drag whose targets are nowhere further apart is good enough [m]."""
REST = (0.253, 0.0)
"""P1's tip at rest, where the target stands first [m]."""
LOW, HIGH = (0.003, -0.04), (0.253, 0.16)
"""Corners of the 250 x 200 mm that the hand moves in [m]."""
CENTRE, RADIUS = (0.038, 0.0), 0.212
"""A circle just inside P1's reach [m]."""
HOLE = (0.11, 0.06)
"""The hand makes for no point with x and |y| below these, but it may cross them [m]."""


class Stroke:
    """One reaching movement: minimum jerk along a line, bowed to one side."""

    def __init__(self, rng: np.random.Generator, start: float, way: Array) -> None:
        distance = float(np.linalg.norm(way))
        peak = rng.uniform(0.05, 0.26)
        self.start, self.way = start, way
        self.duration = max(0.35, 1.875 * distance / peak)
        self.bow = rng.normal(0.0, 0.12) * np.array([-way[1], way[0]])

    def at(self, t: Array) -> Array:
        """Displacement (n, 2) [m] at times (n,) [s]."""
        s = np.clip((t - self.start) / self.duration, 0.0, 1.0)[:, None]
        return s**3 * (10.0 - 15.0 * s + 6.0 * s * s) * self.way + 16.0 * (s * (1.0 - s)) ** 2 * self.bow


def hand(seed: int) -> list[Stroke]:
    """Strokes of about SECONDS from REST, some with a pause before them, most begun before the last one ends."""
    rng = np.random.default_rng(seed)
    strokes: list[Stroke] = []
    at, start = np.array(REST), 0.5
    while start < SECONDS - 2.0:
        goal = somewhere(rng, at)
        strokes.append(Stroke(rng, start, goal - at))
        pauses = rng.random() < 0.2
        start += strokes[-1].duration * (1.0 if pauses else rng.uniform(0.65, 0.9))
        start += rng.uniform(0.4, 1.2) if pauses else 0.0
        at = goal
    return strokes


def somewhere(rng: np.random.Generator, at: Array) -> Array:
    """A point (2,) [m] of the box that the tip can reach, at least 30 mm away from `at`."""
    while True:
        goal = rng.uniform(LOW, HIGH)
        in_hole = goal[0] < HOLE[0] and abs(goal[1]) < HOLE[1]
        if np.hypot(*(goal - CENTRE)) < RADIUS and not in_hole and np.hypot(*(goal - at)) > 0.03:
            return goal


def points(strokes: list[Stroke], t: Array) -> Array:
    """Where the hand is (n, 2) [m] at times (n,) [s]."""
    return REST + sum((stroke.at(t) for stroke in strokes), np.zeros((len(t), 2)))


async def drag(page: Page, mouse: CDPSession, strokes: list[Stroke]) -> None:
    """Move the target like the hand for SECONDS of real time, without waiting until the page has drawn each move."""
    corners = [await page.evaluate(f"window.__tendril.toPixel({mm}, {mm})") for mm in (0.0, 100.0)]
    scale = (np.array(corners[1]) - corners[0]) / 0.1
    handle = await page.evaluate("window.__tendril.handle()")
    await page.mouse.move(*handle)
    await page.mouse.down()
    moves, begin = [], time.monotonic()
    while (now := time.monotonic() - begin) < SECONDS:
        x, y = corners[0] + points(strokes, np.array([now]))[0] * scale
        move = {"type": "mouseMoved", "x": x, "y": y, "button": "left", "buttons": 1}
        moves.append(asyncio.ensure_future(mouse.send("Input.dispatchMouseEvent", move)))
        await asyncio.sleep(PERIOD_S - now % PERIOD_S)
    await asyncio.gather(*moves)
    await page.mouse.up()


async def operate(page: Page, mouse: CDPSession, strokes: list[Stroke]) -> None:
    """Arm, record one drag, disarm. What is not needed is not drawn: it would slow the hand."""
    for control in ("toggle-3d", "pause", "lease-take", "arm"):
        await page.get_by_test_id(control).click()
    await expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    await page.get_by_test_id("record").click()
    await asyncio.sleep(1.0)
    await drag(page, mouse, strokes)
    for control in ("record", "disarm"):
        await page.get_by_test_id(control).click()
    await expect(page.get_by_test_id("state")).to_contain_text("VENTED", timeout=10_000)
    await page.get_by_test_id("lease-release").click()


async def recorded(product: Product, browser: Browser, strokes: list[Stroke]) -> Path:
    """One drag in a page of its own; the recording of it."""
    context = await browser.new_context(viewport={"width": 1280, "height": 720})
    page = await context.new_page()
    await page.goto(product.url)
    await expect(page.get_by_test_id("state")).to_contain_text("VENTED", timeout=20_000)
    await operate(page, await context.new_cdp_session(page), strokes)
    await context.close()
    return max(product.recordings.glob("*.rrd"), key=lambda path: path.stat().st_mtime)


def targets(file: Path) -> Array:
    """Rows (n, 3) of t [s], x and y [m]: each target that the rig was given while it followed, and the last at the end.

    No rows where it was made to hold before the hand let go.
    """
    rows = read_rows(file)
    following = np.flatnonzero(rows["mode"] == Mode.FOLLOW)
    if not len(following):
        return np.empty((0, 3))
    first = following[0]
    t, p = 1e-9 * (rows["t_ns"][first:] - rows["t_ns"][first]), rows["target"][first:]
    if (rows["mode"][first:][t < SECONDS] != Mode.FOLLOW).any() or t[-1] < SECONDS:
        return np.empty((0, 3))
    fresh = np.append(True, np.any(np.diff(p, axis=0) != 0.0, axis=1)) & (t < SECONDS)
    return np.vstack([np.column_stack([t, p])[fresh], [SECONDS, *p[t < SECONDS][-1]]])


def write(path: Path, rows: Array, seed: int, browser: str) -> None:
    """The rows as CSV, to a millisecond and a hundredth of a millimetre, with how they came about in front."""
    lines = [
        "# Task 5, a user-defined path: targets [m] of one drag on the page's plan view, as the rig (P1, twin) had",
        "# them, from the first tick [s] with each; until the next it stays. The last row is the end.",
        f"# Recorded {datetime.now(UTC):%Y-%m-%d %H:%M} UTC through tendril up and Chromium {browser} in real time by",
        f"# python -m tests.e2e.record_live_path --seed {seed}",
        "t,x,y",
    ]
    path.write_text("\n".join([*lines, *(f"{t:.3f},{x:.5f},{y:.5f}" for t, x, y in rows), ""]))


def described(rows: Array) -> str:
    """Size, rate and speed of a path in a line."""
    width, height = 1e3 * np.ptp(rows[:, 1:], axis=0)
    smooth = np.array([np.interp(np.arange(0.0, SECONDS, 0.25), rows[:, 0], rows[:, j]) for j in (1, 2)])
    speed = np.hypot(*np.diff(smooth)) / 0.25
    longest = max(after - before for before, after in pairwise(rows[:, 0]))
    return (
        f"{len(rows)} targets over {width:.0f} x {height:.0f} mm, up to {speed.max():.2f} m/s over 0.25 s, "
        f"slower than 5 mm/s for {100.0 * np.mean(speed < 5e-3):.0f} % of the time, longest gap {longest:.2f} s, "
        f"largest jump {1e3 * np.linalg.norm(np.diff(rows[:, 1:], axis=0), axis=1).max():.1f} mm"
    )


async def record(product: Product, out: Path, seed: int) -> bool:
    """Keep the evenest of ATTEMPTS drags: a machine that stalls lets the target jump, or makes the rig hold."""
    least = np.inf
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        for _ in range(ATTEMPTS):
            rows = targets(await recorded(product, browser, hand(seed)))
            jump = np.linalg.norm(np.diff(rows[:, 1:], axis=0), axis=1).max() if len(rows) else np.inf
            print(described(rows) if len(rows) else "broken off", flush=True)
            if jump < least:
                least = jump
                write(out, rows, seed, browser.version)
            if jump < EVEN:
                break
    return bool(np.isfinite(least))


def main() -> None:
    """Start the product, record, stop it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--seed", type=int, default=SEED)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        product = Product(Path(folder))
        try:
            if not asyncio.run(record(product, asked.out, asked.seed)):
                raise SystemExit(f"all {ATTEMPTS} drags were broken off")
        finally:
            product.stop()


if __name__ == "__main__":
    main()
