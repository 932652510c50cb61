import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from controller.errors import LayoutMismatch, RigUnreachable, TendrilError
from controller.realtime.ring import LAYOUT_WORD, ROW_WORDS, Ring, create_ring, find_ring, ring_path, ring_push
from tests.controller import ring_writer

pytestmark = pytest.mark.alone


def push(ring: Ring, *values: int) -> None:
    for value in values:
        ring_push(ring.header, ring.rows, np.full(ROW_WORDS, value, np.int64))


def test_a_reader_in_another_process_sees_no_torn_row_and_is_told_what_was_overwritten(tmp_path: Path) -> None:
    total = 1_000_000
    ring = create_ring("torn", 1, tmp_path, capacity=256)
    writer = subprocess.Popen([sys.executable, ring_writer.__file__, str(ring.path), str(total)])
    reader = Ring(ring.path, writable=False)
    seen = overwritten = nxt = 0
    while nxt < total:
        start, rows = reader.read(nxt, 200)
        words = np.ascontiguousarray(rows).view(np.int64).reshape(len(rows), ROW_WORDS)
        assert np.array_equal(words, np.repeat(np.arange(start, start + len(rows)), ROW_WORDS).reshape(words.shape))
        seen, overwritten, nxt = seen + len(rows), overwritten + start - nxt, start + len(rows)
        assert writer.poll() in (None, 0)
    assert writer.wait() == 0
    assert seen + overwritten == total
    assert seen > 0
    assert overwritten > 0


def test_a_reader_gets_the_rows_that_are_left_and_the_index_of_the_first(tmp_path: Path) -> None:
    ring = create_ring("left", 1, tmp_path, capacity=8)
    assert ring.newest() is None
    push(ring, *range(20))
    start, rows = ring.read(0, 100)
    assert (start, [int(row["tick"]) for row in rows]) == (13, [13, 14, 15, 16, 17, 18, 19])
    newest = ring.newest()
    assert newest is not None and newest["tick"] == 19
    assert ring.read(20, 5)[0] == 20
    assert len(ring.read(25, 5)[1]) == 0


def test_a_restart_makes_a_new_file_and_keeps_the_last_one(tmp_path: Path) -> None:
    first = create_ring("again", 1, tmp_path, capacity=8)
    push(first, 5)
    reader = Ring(first.path, writable=False)
    second = create_ring("again", 2, tmp_path, capacity=8)
    push(second, 7)
    assert find_ring("again", tmp_path).boot == 2
    assert reader.boot == 1
    assert [int(row["tick"]) for row in reader.read(0, 9)[1]] == [5]
    recorder = Ring(second.path.with_suffix(".last"), writable=False)
    assert recorder.boot == 1
    create_ring("again", 3, tmp_path, capacity=8)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_ring_of_another_layout_or_no_ring_is_refused(tmp_path: Path) -> None:
    ring = create_ring("other", 1, tmp_path, capacity=8)
    ring.header[LAYOUT_WORD] ^= 1
    with pytest.raises(LayoutMismatch, match="run the same version"):
        find_ring("other", tmp_path)
    ring.header[0] = 0
    with pytest.raises(LayoutMismatch, match="not a telemetry ring"):
        find_ring("other", tmp_path)
    with pytest.raises(RigUnreachable, match="no telemetry ring of rig 'none'"):
        find_ring("none", tmp_path)


def test_a_ring_that_goes_while_it_is_looked_for_is_none(tmp_path: Path) -> None:
    path, over, interval = ring_path("brief", tmp_path), threading.Event(), sys.getswitchinterval()

    def come_and_go() -> None:
        while not over.is_set():
            path.touch()
            path.unlink()

    other = threading.Thread(target=come_and_go)
    sys.setswitchinterval(1e-6)
    other.start()
    try:
        for _ in range(2000):
            with pytest.raises(RigUnreachable):
                find_ring("brief", tmp_path)
    finally:
        over.set()
        other.join()
        sys.setswitchinterval(interval)


def test_without_room_nothing_is_left_behind_and_the_error_says_where(tmp_path: Path) -> None:
    with pytest.raises(TendrilError, match=f"no room .* {tmp_path}"):
        create_ring("huge", 1, tmp_path, capacity=1 << 40)
    assert list(tmp_path.iterdir()) == []
