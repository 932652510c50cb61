"""The E-STOP under each flood: from the press to the rig's first row in E_STOP, by the live socket and by HTTP."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.flood import MIXED, viewer_floods
from server.campaign.person import Person
from server.campaign.rows.files import recording
from server.campaign.scene import Kind, Scene
from server.campaign.waiting import Seen, require, wait

BOTH = "both"
"""As the page presses: by the socket and by HTTP at once, and the first counts."""
WAYS = (BOTH, "socket", "http")
PRESSES = {BOTH: 100, "socket": 40, "http": 40}
"""Of each way, in the campaign: of 40 a p99 is hardly more than the longest."""
FLOOD_MAX_S, FLOODED_S = 600.0, 3.0
"""Seconds after which a flood ends by itself, and after which it is at its full rate."""
RECORDED_S = 2.0
"""How long the recording is that a flood asks for."""


def under_flood(scene: Scene) -> Seen:
    """p99 as the page presses; the flood has a session of its own, and its connections are many."""
    with flood(scene.url, MIXED, recorded(scene)):
        found = {way: presses(scene, way, PRESSES[way]) for way in WAYS}
    return Seen("; ".join(told(way, ms) for way, ms in found.items()), _p(99, found[BOTH]))


def recorded(scene: Scene) -> str:
    """The id of a recording that is there to be asked for."""
    scene.operator.reconnect()
    found: str = recording(scene)
    time.sleep(RECORDED_S)
    scene.operator.ask("DELETE", "/api/recordings/current")
    return found


@contextmanager
def flood(url: str, name: str, recording: str) -> Iterator[None]:
    """The flood of this name, from a process of its own, while this lasts."""
    process = subprocess.Popen([sys.executable, "-m", "server.campaign.flood", url, str(FLOOD_MAX_S), name, recording])
    try:
        time.sleep(FLOODED_S)
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
    if way in (BOTH, "socket"):
        who.send(type="e_stop", n=n)
    if way in (BOTH, "http"):
        who.post_bare("/api/command", b'{"request": "e_stop"}')
    row = scene.until(start, (Mode.E_STOP,), 10.0)
    return float(row["t_ns"] - start) * 1e-6


def _p(percent: float, ms: list[float]) -> float:
    return float(np.percentile(ms, percent))


def main() -> None:
    """`python -m server.campaign.rows.stops [PRESSES [NAME ...]]`: quiet, then under each flood, both ways."""
    count, names = int(sys.argv[1]) if len(sys.argv) > 1 else PRESSES[BOTH], sys.argv[2:]
    with tempfile.TemporaryDirectory(prefix="tendril-stops-") as folder:
        scene = Scene(Path(folder, "scene"), Kind(rate_factor=1.0))
        try:
            there, every = recorded(scene), dict[str, float]()
            for name in names or ["", MIXED, *viewer_floods(there)]:
                with flood(scene.url, name, there) if name else nullcontext():
                    found = {way: presses(scene, way, count) for way in WAYS}
                print(name or "quiet", *(told(way, ms) for way, ms in found.items()), sep=", ", flush=True)
                every[name] = _p(99, found[BOTH])
            worst = max(every, key=lambda name: every[name])
            print(f"worst p99 of {len(every)} by {BOTH}: {every[worst]:.1f} ms, under {worst or 'nothing'}")
            print("gap of the loop", trace.longest_gap_ms(scene.since(time.monotonic_ns() - 10**10)), "ms")
        finally:
            scene.close()


if __name__ == "__main__":
    main()
