"""The E-STOP under load: from the press to the rig's first row in E_STOP, by the live socket and by HTTP."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.person import Person
from server.campaign.scene import Kind, Scene
from server.campaign.waiting import Seen, require, wait

WAYS = ("socket", "http")
PRESSES = 40
"""Of each way, in the campaign."""
FLOOD_MAX_S = 600.0
"""Seconds after which a flood ends by itself."""


def under_flood(scene: Scene) -> Seen:
    """p99 of both ways together; the flood has a session of its own, and its connections are many."""
    with flood(scene.url):
        found = {way: presses(scene, way, PRESSES) for way in WAYS}
    return Seen("; ".join(told(way, ms) for way, ms in found.items()), max(_p(99, ms) for ms in found.values()))


@contextmanager
def flood(url: str) -> Iterator[None]:
    """The mixed flood, from a process of its own, while this lasts."""
    process = subprocess.Popen([sys.executable, "-m", "server.campaign.flood", url, str(FLOOD_MAX_S)])
    try:
        time.sleep(3.0)
        require(process.poll() is None, "the flood ended by itself")
        yield
        require(process.poll() is None, "the flood ended by itself")
    finally:
        process.kill()
        process.wait()


def presses(scene: Scene, way: str, count: int) -> list[float]:
    """From each press to the first row in E_STOP [ms]."""
    scene.operator.reconnect()
    return [_press(scene, scene.operator, way, n) for n in range(count)]


def told(way: str, ms: list[float]) -> str:
    """In words."""
    return f"by {way} p50 {_p(50, ms):.1f}, p99 {_p(99, ms):.1f}, max {max(ms):.1f} ms"


def _press(scene: Scene, who: Person, way: str, n: int) -> float:
    if scene.mode == Mode.E_STOP:
        wait(lambda: who.request("POST", "/api/command", request="clear").is_success, 30.0, "a clear")
    start = time.monotonic_ns()
    wait(lambda: scene.mode != Mode.E_STOP, 5.0, "a rig that is not stopped")
    time.sleep(0.02)
    start = time.monotonic_ns()
    if way == "socket":
        who.send(type="e_stop", n=n)
    else:
        who.post_bare("/api/command", b'{"request": "e_stop"}')
    row = scene.until(start, (Mode.E_STOP,), 10.0)
    return float(row["t_ns"] - start) * 1e-6


def _p(percent: float, ms: list[float]) -> float:
    return float(np.percentile(ms, percent))


def main() -> None:
    """`python -m server.campaign.rows.stops [PRESSES]`: quiet, then under the flood, both ways."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    with tempfile.TemporaryDirectory(prefix="tendril-stops-") as folder:
        scene = Scene(Path(folder, "scene"), Kind(rate_factor=1.0))
        try:
            for way in WAYS:
                print("quiet,", told(way, presses(scene, way, count)), flush=True)
            with flood(scene.url):
                for way in WAYS:
                    print("flood,", told(way, presses(scene, way, count)), flush=True)
            print("gap of the loop", trace.longest_gap_ms(scene.since(time.monotonic_ns() - 10**10)), "ms")
        finally:
            scene.close()


if __name__ == "__main__":
    main()
