"""Measures many viewers on one server, and prints JSON. Needs a quiet machine.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.measure_viewers`. Each viewer is a session of its
own with a live socket and a few plots, as the page has them, but without its drawing: `--clients` processes read.
A recording goes on meanwhile. Before and with the viewers: processor time and memory of the server, ticks lost.
"""

import argparse
import asyncio
import json
import multiprocessing
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import Queue
from typing import Any

import httpx
import numpy as np
import psutil
from websockets.asyncio.client import ClientConnection, connect

from controller.realtime.ring import find_ring
from tests.e2e.measure_recording import spent
from tests.e2e.product import Product

PLOTTED = ["p_meas.0", "p_meas.1", "p_ref.0", "p_ref.1", "u.0", "u.1"]
BARS = {"server_core": 1.0, "slowest_hz": 25.0, "gaps": 0}
WARM = 5.0
"""After the last viewer has come [s]."""


@dataclass(frozen=True)
class Crowd:
    """Viewers of one client process, and when they count."""

    origin: str
    token: str
    count: int
    begin: float
    seconds: float
    """Frames are counted for so long from `begin` on (`time.monotonic`)."""


def watch(crowd: Crowd, found: "Queue[list[int]]") -> None:
    """In a process of its own: frames of each viewer within the window."""
    found.put(asyncio.run(_watch(crowd)))


async def _watch(crowd: Crowd) -> list[int]:
    return await asyncio.gather(*(_view(crowd) for _ in range(crowd.count)))


async def _view(crowd: Crowd) -> int:
    async with httpx.AsyncClient(base_url=crowd.origin, trust_env=False, timeout=60.0) as browser:
        answer = await browser.post("/api/session", json={"token": crowd.token})
        answer.raise_for_status()
        cookies = "; ".join(f"{name}={value}" for name, value in browser.cookies.items())
    url = f"{crowd.origin.replace('http', 'ws')}/ws/live"
    headers = {"Cookie": cookies}
    async with connect(url, additional_headers=headers, proxy=None, compression=None, max_size=None) as socket:
        await socket.send(json.dumps({"type": "plots", "channels": PLOTTED, "since": None}))
        return await _count(socket, crowd)


async def _count(socket: ClientConnection, crowd: Crowd) -> int:
    frames = 0
    async for message in socket:
        now = time.monotonic()
        if now > crowd.begin + crowd.seconds:
            break
        frames += now > crowd.begin and isinstance(message, bytes) and message[0] == 1
    return frames


@contextmanager
def crowds(product: Product, count: int, processes: int, begin: float, seconds: float) -> Iterator["Queue[list[int]]"]:
    """The viewers, in `processes` clients."""
    spawn = multiprocessing.get_context("spawn")
    found, token = spawn.Queue(), product.url.split("token=")[1]
    shares = [count // processes + (n < count % processes) for n in range(processes)]
    running = [
        spawn.Process(target=watch, args=(Crowd(product.origin, token, share, begin, seconds), found))
        for share in shares
    ]
    for process in running:
        process.start()
    yield found
    for process in running:
        process.join()


def measure(product: Product, seconds: float) -> dict[str, float]:
    """Server and rig over the next `seconds`."""
    ring, server = find_ring(product.rig), product.child("server.app")
    before, used, start = ring.newest(), spent(server), time.monotonic()
    time.sleep(seconds)
    after, share = ring.newest(), (spent(server) - used) / (time.monotonic() - start)
    assert before is not None
    assert after is not None
    return {"server_core": share, "server_mb": memory(server), "lost": float(after["lost"] - before["lost"])}


def memory(process: psutil.Process) -> float:
    """Resident memory [MB]."""
    return float(process.memory_info().rss) / 1e6


def main() -> None:
    """Measure and print."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--viewers", type=int, default=100)
    asked.add_argument("--seconds", type=float, default=60.0)
    asked.add_argument("--clients", type=int, default=2)
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as folder, Product(Path(folder)) as product:
        figures = run(product, options.viewers, options.seconds, options.clients)
    print(json.dumps({"figures": figures, "bars": BARS}, indent=2))


def run(product: Product, viewers: int, seconds: float, clients: int) -> dict[str, Any]:
    """Alone, then with the viewers and a recording."""
    page = httpx.Client(base_url=product.origin, trust_env=False, timeout=60.0)
    for path, body in (("session", {"token": product.url.split("token=")[1]}), ("lease", None)):
        page.post(f"/api/{path}", json=body).raise_for_status()
    time.sleep(WARM)
    alone = measure(product, seconds / 2)
    come = 10.0 + 0.1 * viewers
    begin = time.monotonic() + come + WARM
    with crowds(product, viewers, clients, begin, seconds) as found:
        page.post("/api/lease").raise_for_status()
        page.post("/api/recordings", json={"name": "crowd"}).raise_for_status()
        time.sleep(begin - time.monotonic())
        crowded = measure(product, seconds)
        page.post("/api/lease").raise_for_status()
        recording = page.delete("/api/recordings/current").json()
        frames = [number for _ in range(clients) for number in found.get()]
    rates = np.array(frames) / seconds
    return {
        "alone": alone,
        "crowded": crowded,
        "gaps": recording["gaps"],
        "slowest_hz": float(rates.min()),
        "median_hz": float(np.median(rates)),
        "kb_per_viewer": (crowded["server_mb"] - alone["server_mb"]) * 1e3 / viewers,
    }


if __name__ == "__main__":
    main()
