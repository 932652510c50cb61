"""A recorder that is killed while it records at the rig's pace."""

import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from controller.errors import RecordingError
from recordings.format import tool
from recordings.read.reader import read_rows
from recordings.store.store import Store
from tests.recordings.kill_at_random import LOSS_MAX, kill_once, last_said
from tests.recordings.synthetic import telemetry_rows

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]


def test_a_killed_recording_loses_little_and_is_mended(tmp_path: Path) -> None:
    handed_over = _record_and_kill(tmp_path, at_tick=2500)
    store = Store(tmp_path)
    [left] = store.list()
    path = store.path(left.id)
    assert not left.complete
    assert left.rows > 0
    assert store.broken() == (left.id,)
    _check(path, handed_over)
    with pytest.raises(RecordingError, match="verify"):
        tool.run("rrd", "verify", str(path), timeout=60)

    mended = store.repair(left.id)
    tool.run("rrd", "verify", str(path), timeout=60)
    assert (mended.recovered, mended.complete, mended.gaps) == (True, False, 0)
    assert mended.rows == _check(path, handed_over)
    assert store.broken() == ()
    assert store.compact(left.id).rows == mended.rows
    assert _check(path, handed_over) == mended.rows
    assert store.list() == [store.find(left.id)]


def test_a_torn_end_is_dropped_and_the_rest_is_readable_and_mended(tmp_path: Path) -> None:
    handed_over = _record_and_kill(tmp_path, at_tick=1500)
    store = Store(tmp_path)
    path = store.path(store.list()[0].id)
    whole = path.read_bytes()
    for cut in (1, 10, 3000, 30_000):
        path.write_bytes(whole[:-cut])
        _check(path, handed_over, torn_bytes=cut)
    rows = store.repair(path.stem).rows
    tool.run("rrd", "verify", str(path), timeout=60)
    assert _check(path, handed_over, torn_bytes=30_000) == rows


def test_a_running_recording_is_neither_broken_nor_mended(tmp_path: Path) -> None:
    process = _start(tmp_path)
    try:
        _wait_for_tick(process, 100)
        store = Store(tmp_path)
        [running] = store.list()
        assert store.broken() == ()
        with pytest.raises(RecordingError, match="still being written"):
            store.repair(running.id)
    finally:
        _kill(process)


def _check(path: Path, handed_over: tuple[int, int], torn_bytes: int = 0) -> int:
    """The rows in the file are the first ones, exactly, and at most LOSS_MAX are missing; their number.

    More only for as long as the machine itself was late.

    A batch of 200 rows has more than 30 kB, so cutting off that many bytes costs one or two batches more.
    """
    found = read_rows(path)
    ticks = found["tick"]
    rows = telemetry_rows(len(ticks))
    assert (ticks == rows["tick"]).all()
    np.testing.assert_array_equal(found["p_hat"], rows["p_hat"])
    np.testing.assert_array_equal(found["slot"], rows["slot"])
    given, late = handed_over
    assert given - ticks[-1] <= LOSS_MAX + late + 500 * (torn_bytes > 0)
    return len(ticks)


def _record_and_kill(folder: Path, at_tick: int) -> tuple[int, int]:
    """Kill a recorder with -9; the last tick that it had been given, and how late the machine was [ticks]."""
    process = _start(folder)
    seen = ""
    try:
        seen = _wait_for_tick(process, at_tick)
    finally:
        seen += _kill(process)
    return last_said(seen)


def _start(folder: Path) -> "subprocess.Popen[str]":
    program = [sys.executable, "-m", "tests.recordings.write_until_killed", str(folder)]
    return subprocess.Popen(program, stdout=subprocess.PIPE, text=True)


def _wait_for_tick(process: "subprocess.Popen[str]", tick: int) -> str:
    assert process.stdout
    return next(line for line in process.stdout if int(line.split()[0]) >= tick)


def _kill(process: "subprocess.Popen[str]") -> str:
    """Kill with -9; what it still had printed."""
    process.kill()
    return process.communicate()[0]


@pytest.mark.parametrize("seed", range(3))
def test_killed_at_any_moment_at_most_0_3_s_are_lost(tmp_path: Path, seed: int) -> None:
    kill_once(tmp_path, random.Random(seed).uniform(0.2, 2.0))
