"""E_STOP and FAULT outlive the rig's process: with the real one, killed, ended and started again."""

import json
import os
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from controller.realtime.latch import Latch, read_latch
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry, TwinFaults
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters, SafetyLimits
from tests.controller.live_rig import LiveRig, live_rig, wait_for

pytestmark = pytest.mark.alone


def row(mode: Mode, cause: Cause, tick: int = 5) -> np.void:
    """One of the telemetry."""
    found = np.zeros(1, record_dtype(Telemetry))
    found["mode"], found["cause"], found["tick"] = mode, cause, tick
    return found[0]


def killed(rig: LiveRig) -> None:
    """At once, as by a power cut."""
    rig.process.kill()
    rig.process.wait()


@pytest.mark.parametrize("end", ["kill", "terminate"])
def test_an_e_stop_is_there_again_after_any_end_of_the_rig(tmp_path: Path, end: str) -> None:
    with live_rig(tmp_path) as rig:
        rig.operator.arm_and_follow()
        assert rig.operator.client.stop(1, rig.ready.boot, "Ada Lovelace (operator)").detail == "E_STOP"
        getattr(rig.process, end)()
        rig.process.wait()
    with live_rig(tmp_path) as rig:
        first = rig.ring().read(0, 1)[1][0]
        assert (first["mode"], first["cause"]) == (Mode.E_STOP, Cause.OPERATOR)
        info = rig.operator.client.info
        assert info is not None and info.latched is not None
        assert (info.latched.by, info.latched.cause) == ("Ada Lovelace (operator)", Cause.OPERATOR)
        refused = rig.operator.send(Request.ARM)
        assert not refused.accepted and "clear the E-STOP first" in refused.detail
        assert rig.operator.send(Request.CLEAR).mode == Mode.VENTED
        killed(rig)
    with live_rig(tmp_path) as rig:
        assert (rig.operator.newest()["mode"], rig.operator.newest()["cause"]) == (Mode.VENTED, Cause.START)
        assert rig.operator.send(Request.ARM).accepted


def test_a_fault_that_nobody_asked_for_is_there_again(tmp_path: Path) -> None:
    limits = SafetyLimits(server_hold=8.0, operator_timeout=8.0, loop_gap=1.0)
    parameters = RigParameters(limits=limits)
    with live_rig(tmp_path, parameters=parameters) as rig:
        rig.operator.arm_and_follow()
        rig.operator.client.faults(TwinFaults(marker_loss=1.0))
        rig.operator.first("mode", Mode.FAULT)
        wait_for((tmp_path / "test.latch.json").exists)
        killed(rig)
    with live_rig(tmp_path, parameters=parameters) as rig:
        newest = rig.operator.newest()
        assert (newest["mode"], newest["cause"]) == (Mode.FAULT, Cause.MEASUREMENT_LOST)
        assert not newest["u"].any()
        assert rig.operator.send(Request.CLEAR).accepted
        assert not (tmp_path / "test.latch.json").exists()  # gone before the answer


@pytest.mark.parametrize("left", ["half", "folder", "other"])
def test_a_latch_that_cannot_be_read_stops_the_rig_until_it_is_cleared(tmp_path: Path, left: str) -> None:
    path = tmp_path / "test.latch.json"
    if left == "folder":
        path.mkdir()
    else:
        path.write_text('{"mode": 6, "cau' if left == "half" else '{"mode": 1}')
    with live_rig(tmp_path) as rig:
        assert (rig.operator.newest()["mode"], rig.operator.newest()["cause"]) == (Mode.E_STOP, Cause.START)
        assert not rig.operator.send(Request.ARM).accepted
        wait_for(lambda: path.is_file() and json.loads(path.read_text())["mode"] == Mode.E_STOP)
        assert rig.operator.send(Request.CLEAR).accepted
        assert not path.exists()
        assert rig.operator.send(Request.ARM).accepted


def test_a_row_from_before_the_clear_latches_nothing_again(tmp_path: Path) -> None:
    """The pump reads the ring a moment later than the answer does."""
    latch = Latch(tmp_path / "a.json")
    latch.look(row(Mode.FAULT, Cause.RESIDUAL, 5))
    assert latch.on_disk(20) == "" and read_latch(tmp_path / "a.json") == latch.kept
    latch.clear(row(Mode.VENTED, Cause.OPERATOR, 9))
    latch.look(row(Mode.FAULT, Cause.RESIDUAL, 8))
    assert latch.kept is None and latch.on_disk(20) == "" and read_latch(tmp_path / "a.json") is None
    latch.look(row(Mode.FAULT, Cause.RESIDUAL, 10))
    assert latch.kept is not None
    latch.close()


def test_who_pressed_first_stays_and_the_mode_is_the_newest(tmp_path: Path) -> None:
    latch = Latch(tmp_path / "a.json")
    latch.look(row(Mode.FAULT, Cause.RESIDUAL))
    latch.look(row(Mode.E_STOP, Cause.OPERATOR))  # the pump saw it first
    for by in ("Ada", "Bob"):
        latch.look(row(Mode.E_STOP, Cause.OPERATOR), by)
    assert latch.on_disk(20) == ""
    kept = read_latch(tmp_path / "a.json")
    assert kept is not None and (kept.mode, kept.by) == (Mode.E_STOP, "Ada")
    latch.close()


def test_a_disk_that_takes_nothing_is_said_and_tried_again(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    latch = Latch(folder / "a.json")  # the folder is not there: a disk that is not mounted
    latch.look(row(Mode.E_STOP, Cause.OPERATOR))
    assert "cannot be written: No such file or directory" in latch.on_disk(20)
    folder.mkdir()
    wait_for(lambda: latch.on_disk(0.1) == "")
    assert read_latch(folder / "a.json") == latch.kept
    latch.close()
    assert "latch" not in [thread.name for thread in threading.enumerate()]


def test_a_disk_that_hangs_holds_up_no_one_for_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stands in for the disk: no file system here hangs on request."""
    goes_on = threading.Event()
    monkeypatch.setattr(os, "fsync", lambda descriptor: goes_on.wait(20))
    latch = Latch(tmp_path / "a.json")
    before = time.monotonic()
    latch.look(row(Mode.E_STOP, Cause.OPERATOR))
    assert latch.on_disk(0.05) == "the disk does not answer"
    assert time.monotonic() - before < 10  # not the 20 s of the disk
    goes_on.set()
    assert latch.on_disk(20) == ""
    latch.close()
