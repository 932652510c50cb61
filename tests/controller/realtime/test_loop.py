"""The compiled loop in a process of its own, stopped and continued, and what its rows then say about time."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from controller.realtime.ring import BASELINE_LOST, BASELINE_TICKS, GRID_NS
from controller.research.bench.loop_bench import measure_loop
from tests.controller.live_rig import LiveRig, live_rig, wait_for

pytestmark = pytest.mark.alone

PERIOD_NS = 1_000_000
PAUSE = 0.3


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[LiveRig]:
    with live_rig(tmp_path, baseline=True) as rig:
        yield rig


def stands_still(pid: int) -> bool:
    """Whether every thread of the process is stopped."""
    threads = Path(f"/proc/{pid}/task").glob("*/stat")
    return all(stat.read_text().rpartition(")")[2].split()[0] == "T" for stat in threads)


def pause(rig: LiveRig) -> None:
    """Freeze the process for PAUSE seconds and wait for rows from after it."""
    os.kill(rig.process.pid, signal.SIGSTOP)
    wait_for(lambda: stands_still(rig.process.pid))  # a busy machine takes its time to stop a process
    time.sleep(PAUSE)
    os.kill(rig.process.pid, signal.SIGCONT)
    wait_for(lambda: rig.operator.newest()["lost"] >= PAUSE * 900)


def test_every_tick_lies_on_the_first_grid_and_lost_slots_are_counted_not_caught_up(rig: LiveRig) -> None:
    pause(rig)
    head = rig.ring().head
    wait_for(lambda: rig.operator.newest()["tick"] > head + 100)
    rows, grid = rig.operator.rows(), int(rig.ring().header[GRID_NS])
    assert np.all(np.diff(rows["tick"]) == 1)
    assert np.array_equal(rows["slot"], rows["tick"] + rows["lost"])
    assert np.array_equal(rows["t_ns"] - rows["lateness_ns"], grid + rows["slot"] * PERIOD_NS)
    assert rows["lateness_ns"].min() >= 0
    assert np.diff(rows["t_ns"]).max() >= PAUSE * 1e9
    assert rig.operator.client.gaps == 0


def test_the_bare_thread_loses_the_same_pause_by_the_same_rule(rig: LiveRig) -> None:
    header = rig.ring().header
    pause(rig)
    wait_for(lambda: header[BASELINE_LOST] >= PAUSE * 900)
    slots = header[BASELINE_TICKS] + header[BASELINE_LOST]
    assert abs(int(slots) - int(rig.ring().newest()["slot"])) < 1000  # type: ignore[index]


def test_the_bench_counts_ticks_and_losses_of_exactly_its_interval(rig: LiveRig) -> None:
    figures = measure_loop(rig.operator.client, 2.0, rig.settings.folder)
    assert figures["policy"] == rig.operator.client.info.policy  # type: ignore[union-attr]
    assert figures["ticks"] + figures["lost"] - 1 == pytest.approx(figures["seconds"] * 1000, abs=PAUSE * 1000)
    late = figures["lateness_us"]
    assert 0.0 <= late["p50"] <= late["p99"] <= late["p999"] <= late["max"]
    assert figures["baseline_lost"] >= 0
