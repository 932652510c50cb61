"""The rig process with its twin, over the real link: commands, refusals, watchdogs, and how it ends."""

import fcntl
import os
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import psutil
import pytest

from controller.errors import ParameterError, RigUnreachable
from controller.link import PlannedRows
from controller.realtime import rig as process
from controller.realtime.ring import STOP
from controller.schema.hardware import CHANNELS, Hardware, MotionCapture, Valves
from controller.schema.messages import Command, TwinFaults
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import Law, RigParameters, SafetyLimits, Settings
from controller.system.whole_file import open_lock
from controller.virtual.board import BoardPeer
from controller.virtual.firmware import compiler
from controller.virtual.peers import Drive
from controller.virtual.registry import capture_peer
from tests.controller.live_rig import LiveRig, live_rig, wait_for

pytestmark = pytest.mark.alone

CRASHING_PUMP = """
import sys
from controller.link import PlannedRows
from controller.link.rig_end import RigEnd
from controller.realtime.rig import RigSettings, run_rig


def publish(self, rows, real=RigEnd.publish):
    real(self, rows)
    if rows["command_n"][-1] == 2:
        raise OSError("the pump's own mistake")

RigEnd.publish = publish
run_rig(RigSettings.model_validate_json(sys.argv[1]))
"""

PARENT = """
import os, subprocess, sys
from controller.realtime.settings import RigSettings

settings = RigSettings.model_validate_json(sys.argv[1]).model_copy(update={"parent": os.getpid()})
subprocess.run([sys.executable, "-m", "controller.realtime", settings.model_dump_json()])
"""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRig]:
    """One rig for the tests that leave it as they found it: VENTED."""
    with live_rig(tmp_path_factory.mktemp("rig")) as rig:
        yield rig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[LiveRig]:
    with live_rig(tmp_path) as rig:
        yield rig


def test_a_reply_comes_after_the_loop_has_looked_and_says_what_it_did(shared: LiveRig) -> None:
    operator = shared.operator
    reply = operator.send(Request.ARM, settings=Settings(law=Law.FF_P))
    newest = shared.ring().newest()
    assert newest is not None and (newest["command_n"], newest["mode"]) == (operator.n, Mode.HOLD)
    assert (reply.n, reply.accepted, reply.mode, reply.cause) == (operator.n, True, Mode.HOLD, Cause.OPERATOR)
    assert newest["law"] == Law.FF_P
    assert operator.send(Request.REST).mode == Mode.REST
    operator.first("cause", Cause.RESTED)


def test_a_refusal_names_the_mode_and_the_way_out(shared: LiveRig) -> None:
    send = shared.operator.send
    refused = send(Request.FOLLOW)
    assert (refused.accepted, refused.mode, refused.cause) == (False, Mode.VENTED, Cause.WRONG_MODE)
    assert refused.detail == "refused: FOLLOW is not possible in VENTED; arm first"
    assert send().accepted
    assert send(Request.ARM, boot=1).cause == Cause.WRONG_BOOT
    assert send(boot=1, settings=Settings(law=Law.FF_P)).cause == Cause.WRONG_BOOT  # refused whole
    newest = shared.ring().newest()
    assert newest is not None and newest["law"] == Settings().law
    stop = shared.operator.client.stop(secrets.randbits(62), boot=1)  # it was on its way when that rig ended
    assert (stop.accepted, stop.mode, stop.cause) == (False, Mode.VENTED, Cause.WRONG_BOOT)
    assert send().mode == Mode.VENTED
    old = send(Request.ARM, request_n=0)
    assert not old.accepted and "is older than request" in old.detail
    assert send(Request.E_STOP, boot=1).mode == Mode.E_STOP
    assert send(Request.ARM).detail == "refused: ARM is not possible in E_STOP; clear the E-STOP first"
    assert send(Request.CLEAR).mode == Mode.VENTED
    assert send(Request.ARM).accepted
    assert send(Request.TRACK).cause == Cause.NO_REFERENCE
    with pytest.raises(ParameterError, match="reference of 3 points cannot go on at 3 for 9 ticks"):
        shared.operator.client.plan(PlannedRows(np.full((3, 2), 0.2), again=3, ticks=9))
    assert send(Request.TRACK).cause == Cause.NO_REFERENCE
    assert send(Request.FOLLOW).accepted
    assert send(Request.TRACK).cause == Cause.WRONG_MODE
    assert send(Request.E_STOP).accepted and send(Request.CLEAR).mode == Mode.VENTED


@pytest.mark.parametrize("field", ["n", "request_n", "presence"])
@pytest.mark.parametrize("request_", [Request.NONE, Request.HOLD])
@pytest.mark.parametrize("value", [2**63 - 1, 2**62, 2**40, -(2**63)])
def test_no_number_of_a_record_takes_stop_or_presence_or_later_commands_away(
    shared: LiveRig, field: str, request_: Request, value: int
) -> None:
    operator, boot = shared.operator, shared.ready.boot
    record = Command(boot=boot, n=operator.n, request=request_, request_n=operator.request_n, presence=operator.n)
    try:
        told = operator.client.command(record.model_copy(update={field: value})).detail
    except ParameterError as error:
        told = str(error)
    stopped = operator.client.stop(secrets.randbits(62), boot)
    assert (stopped.accepted, stopped.mode) == (True, Mode.E_STOP)
    operator.request_n = stopped.n
    for request in (Request.CLEAR, Request.ARM, Request.FOLLOW):
        assert operator.send(request, target=(0.24, 0.02)).accepted
    assert operator.send(Request.E_STOP).mode == Mode.E_STOP and operator.send(Request.CLEAR).mode == Mode.VENTED
    assert f"{field} = {value}" in told


def test_replay_gives_the_rows_of_the_ring_byte_for_byte(shared: LiveRig) -> None:
    wait_for(lambda: shared.ring().head > 300)
    start, rows = shared.ring().read(50, 200)
    replayed = shared.operator.client.replay(50, 200)
    assert start == 50
    assert replayed.tobytes() == rows.tobytes()
    assert len(shared.operator.client.replay(10**9, 5)) == 0


def test_the_tip_follows_and_every_row_arrives(shared: LiveRig) -> None:
    operator = shared.operator
    operator.arm_and_follow()
    for _ in range(100):
        assert operator.send(Request.FOLLOW, target=(0.22, 0.05)).accepted
        time.sleep(0.02)
    row = operator.newest()
    assert np.hypot(*(row["p_hat"] - (0.22, 0.05))) < 0.02
    assert np.all(np.isfinite(row["twin_backbone"]))
    assert np.all(np.diff(operator.rows()["tick"]) == 1)
    assert operator.send(Request.E_STOP).accepted and operator.send(Request.CLEAR).accepted


def test_a_second_process_of_the_same_rig_is_refused(shared: LiveRig) -> None:
    command = [sys.executable, "-m", "controller.realtime", shared.settings.model_dump_json()]
    second = subprocess.run(command, capture_output=True, text=True)
    assert second.returncode != 0
    assert "rig 'test' already runs on this machine" in second.stderr
    assert shared.ring().boot == shared.ready.boot


def test_a_frozen_process_holds_when_it_goes_on(rig: LiveRig) -> None:
    rig.operator.arm_and_follow()
    os.kill(rig.process.pid, signal.SIGSTOP)
    time.sleep(0.2)
    os.kill(rig.process.pid, signal.SIGCONT)
    stalled = rig.operator.first("cause", Cause.LOOP_STALLED)
    assert rig.operator.rows()["mode"][stalled] == Mode.HOLD
    assert rig.operator.send().mode == Mode.HOLD
    assert rig.operator.send(Request.FOLLOW, target=(0.24, 0.02)).mode == Mode.FOLLOW


def test_a_silent_server_makes_it_hold_then_rest_at_their_times(tmp_path: Path) -> None:
    limits = SafetyLimits(operator_timeout=8.0, server_rest=1.0, loop_gap=1.0)
    with live_rig(tmp_path, parameters=RigParameters(limits=limits)) as rig:
        rig.operator.arm_and_follow()
        rest = rig.operator.first("mode", Mode.REST)
        rows = rig.operator.rows()
        hold = int(np.argmax(rows["cause"] == Cause.SERVER_LOST))
        assert rows["mode"][hold] == Mode.HOLD
        assert rows["server_age"][hold - 1] <= limits.server_hold < rows["server_age"][hold]
        assert rows["server_age"][rest - 1] <= limits.server_rest < rows["server_age"][rest]
        assert rows["cause"][rest] == Cause.SERVER_LOST
        rig.operator.first("cause", Cause.RESTED)


def test_commands_without_presence_hold_at_the_operator_timeout(tmp_path: Path) -> None:
    limits = SafetyLimits(loop_gap=1.0, server_hold=8.0)
    with live_rig(tmp_path, parameters=RigParameters(limits=limits)) as rig:
        operator = rig.operator
        operator.arm_and_follow()
        shown = operator.n
        wait_for(lambda: (time.sleep(0.05), operator.send(presence=shown).mode == Mode.HOLD)[1])
        hold = operator.first("cause", Cause.OPERATOR_LOST)
        rows = operator.rows()
        assert rows["operator_age"][hold - 1] <= limits.operator_timeout < rows["operator_age"][hold]
        assert rows["server_age"][hold] < rows["operator_age"][hold]


def test_sigterm_leaves_a_last_vented_row_sent_and_in_the_ring_whose_file_goes(rig: LiveRig) -> None:
    rig.operator.arm_and_follow()
    ring = rig.ring()
    rig.process.terminate()
    assert rig.process.wait(10) == 0
    last = ring.newest()
    assert last is not None and (last["mode"], last["cause"]) == (Mode.VENTED, Cause.OPERATOR)
    assert not last["pressure_cmd"].any() and not last["u"].any()
    wait_for(lambda: rig.operator.newest()["tick"] == last["tick"])
    assert not ring.path.exists()
    wait_for(lambda: not rig.operator.client.connected)


def test_an_exception_in_the_main_thread_stops_the_loop_vented(tmp_path: Path) -> None:
    with live_rig(tmp_path, ["-c", CRASHING_PUMP]) as rig:
        ring = rig.ring()
        assert rig.operator.send(Request.ARM).accepted
        with suppress(RigUnreachable):
            rig.operator.send()
        assert rig.process.wait(20) == 1
        last = ring.newest()
        assert last is not None and (last["mode"], last["cause"]) == (Mode.VENTED, Cause.PUMP_LOST)
        assert not last["pressure_cmd"].any()


def test_without_its_parent_it_rests_and_then_ends(tmp_path: Path) -> None:
    limits = SafetyLimits(server_hold=0.2, server_rest=0.4)
    with live_rig(tmp_path, ["-c", PARENT], parameters=RigParameters(limits=limits)) as rig:
        rig.operator.arm_and_follow()
        ring = rig.ring()
        rig.process.kill()
        wait_for(lambda: ring.header[STOP] == Cause.SERVER_LOST)
        wait_for(lambda: rig.operator.newest()["tick"] == ring.head - 1 and not rig.operator.client.connected)
        rows = rig.operator.rows()
        assert Mode.REST in rows["mode"]
        assert (rows["mode"][-1], rows["cause"][-1]) == (Mode.VENTED, Cause.SERVER_LOST)


def test_without_its_parent_it_ends_in_e_stop_and_makes_room_for_the_next(tmp_path: Path) -> None:
    with live_rig(tmp_path, ["-c", PARENT]) as rig:
        assert rig.operator.client.stop(1, rig.ready.boot).mode == Mode.E_STOP
        rig.process.kill()
        last = _last_row_of_an_orphan(rig)
        assert (last["mode"], last["cause"]) == (Mode.E_STOP, Cause.OPERATOR)


def test_without_its_parent_it_ends_in_fault_once_it_is_at_rest(tmp_path: Path) -> None:
    slow = RigParameters().controller.model_copy(update={"rest_rate": 0.01})
    limits = SafetyLimits(server_hold=8.0, operator_timeout=8.0, loop_gap=1.0)
    with live_rig(tmp_path, ["-c", PARENT], parameters=RigParameters(limits=limits, controller=slow)) as rig:
        rig.operator.arm_and_follow()
        wait_for(lambda: np.abs(rig.operator.newest()["u"]).max() > 0.01)
        rig.operator.client.faults(TwinFaults(marker_loss=1.0))
        rig.operator.first("mode", Mode.FAULT)
        rig.process.kill()
        last = _last_row_of_an_orphan(rig)
        assert (last["mode"], last["cause"]) == (Mode.VENTED, Cause.SERVER_LOST)
        rows = rig.operator.rows()
        assert not rows["u"][-2].any() and rows["mode"][-2] == Mode.FAULT, "it rests before it ends"


def _last_row_of_an_orphan(rig: LiveRig) -> np.void:
    """Of a rig that ends by itself; another one may begin then."""
    ring = rig.ring()
    wait_for(lambda: ring.header[STOP] == Cause.SERVER_LOST)
    wait_for(lambda: rig.operator.newest()["tick"] == ring.head - 1 and not rig.operator.client.connected)
    with open_lock(ring.path.with_suffix(".lock")) as file:
        wait_for(lambda: _locked(file))
    return rig.operator.newest()


def _locked(file: BinaryIO) -> bool:
    with suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


@pytest.mark.skipif(compiler() is None, reason="no compiler for the board's firmware")
def test_a_rig_that_ends_in_e_stop_leaves_the_supply_cut(tmp_path: Path) -> None:
    drives: list[Drive] = []
    board = BoardPeer(lambda: np.zeros(CHANNELS), drives.append)
    board.plug()
    with closing(board):
        valves = Valves(driver="serial", options=dict(board.options))
        camera = MotionCapture(driver="json", options=dict(capture_peer("json", {}).options))
        hardware = Hardware(motion_capture=camera, valves=valves)
        with live_rig(tmp_path, parameters=RigParameters(hardware=hardware)) as rig:
            client = rig.operator.client
            wait_for(lambda: client.drivers().drivers[1].state == "running")
            assert client.stop(1, rig.ready.boot).mode == Mode.E_STOP
            wait_for(lambda: drives[-1].cut)
            before, ring = len(drives), rig.ring()
            rig.process.terminate()
            assert rig.process.wait(10) == 0
            time.sleep(0.3)  # the board's own watchdog
            last = ring.newest()
            assert last is not None and (last["mode"], last["cause"]) == (Mode.E_STOP, Cause.OPERATOR)
        assert all(drive.vent and drive.cut for drive in drives[before:])


@pytest.mark.parametrize(("compiled", "again", "times"), [(True, "", 1), (True, "1", 0), (False, "", 0)])
def test_a_rig_that_had_to_compile_begins_anew_but_once(
    monkeypatch: pytest.MonkeyPatch, compiled: bool, again: str, times: int
) -> None:
    begun: list[tuple[Any, ...]] = []
    monkeypatch.setattr(process, "compile_loop", lambda rig, twin: compiled)
    monkeypatch.setattr(os, "execve", lambda *given: begun.append(given))
    monkeypatch.setenv(process.AGAIN, again) if again else monkeypatch.delenv(process.AGAIN, raising=False)
    process.load_kernels(RigParameters())
    assert [(given[1], given[2][process.AGAIN]) for given in begun] == [(sys.orig_argv, "1")] * times


@pytest.mark.long
def test_a_rig_that_found_nothing_compiled_is_not_larger_than_one_that_did(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    sizes = []
    for name in ("first", "second"):
        folder = tmp_path / name
        folder.mkdir()
        with live_rig(folder) as rig:
            sizes.append(psutil.Process(rig.process.pid).memory_info().rss)
    assert sizes[0] < 1.1 * sizes[1]
