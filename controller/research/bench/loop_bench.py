"""The live loop beside a bare thread of the same priority: what it loses more than the machine takes from anyone."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypedDict

import numpy as np

from controller.errors import RigUnreachable
from controller.link import RigClient
from controller.realtime.ring import BASELINE_LOST, CAPACITY, Ring, find_ring, remove_rings
from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import Supervisor
from controller.system.progress import ProgressCallback, no_progress

POLL_S = 1.0
"""Pause between two readings of the ring [s], far below the time it holds."""
COLUMNS = np.dtype([("slot", "<i8"), ("t_ns", "<i8"), ("lateness_ns", "<i8")])


class Lateness(TypedDict):
    """Wake-up after the deadline [us]."""

    p50: float
    p99: float
    p999: float
    max: float


class LoopFigures(TypedDict):
    """The entry `loop` of `tendril bench --json`."""

    seconds: float
    ticks: int
    lost: int
    baseline_lost: int
    lateness_us: Lateness
    policy: str


@contextmanager
def bench_rig(settings: RigSettings) -> Iterator[Supervisor]:
    """A rig as `settings` say, with the bare thread beside its loop, ready to be connected to; leaves no files."""
    supervisor = Supervisor(settings.model_copy(update={"baseline": True}))
    supervisor.start()
    try:
        supervisor.wait_ready()
        yield supervisor
    finally:
        supervisor.stop()
        remove_rings(settings.rig, settings.folder)


def measure_loop(
    client: RigClient, seconds: float, folder: Path | None = None, told: ProgressCallback = no_progress
) -> LoopFigures:
    """Loop figures over `seconds` [s] from now, of the rig on this machine that `client` is connected to.

    The rows come straight from the shared ring (in `folder`, None for the usual places), so the link has no more to do.
    """
    if client.info is None:
        raise RigUnreachable("no rig is connected: nothing to measure")
    ring = find_ring(client.info.rig, folder)
    if ring.boot != client.info.boot:
        raise RigUnreachable(f"rig {client.info.rig!r} runs on another machine, or has restarted just now")
    ring.newest()  # compiles the reader, which would otherwise lengthen the measurement
    baseline = int(ring.header[BASELINE_LOST])
    rows = collect(ring, seconds, told)
    lateness = np.percentile(rows["lateness_ns"] * 1e-3, [50.0, 99.0, 99.9, 100.0]).tolist()
    return LoopFigures(
        seconds=round(float(rows["t_ns"][-1] - rows["t_ns"][0]) * 1e-9, 3),
        ticks=len(rows),
        lost=int(rows["slot"][-1] - rows["slot"][0]) + 1 - len(rows),
        baseline_lost=int(ring.header[BASELINE_LOST]) - baseline,
        lateness_us=Lateness(p50=lateness[0], p99=lateness[1], p999=lateness[2], max=lateness[3]),
        policy=client.info.policy,
    )


def collect(ring: Ring, seconds: float, told: ProgressCallback = no_progress) -> np.ndarray:
    """The COLUMNS of every row written within `seconds` [s] from now."""
    end = time.monotonic() + seconds
    following, parts = ring.head, []
    while (left := end - time.monotonic()) > 0.0:
        time.sleep(min(POLL_S, left))
        start, rows = ring.read(following, CAPACITY)
        if start != following or not len(rows):
            raise RigUnreachable("the loop stood still, or its ring was not read in time")
        parts.append(rows[list(COLUMNS.names or ())].astype(COLUMNS))
        following += len(rows)
        told(1.0 - max(0.0, end - time.monotonic()) / seconds)
    return np.concatenate(parts)
