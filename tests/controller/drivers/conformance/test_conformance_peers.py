"""Drivers whose far end is another package: each keeps to every rule against a peer that speaks its wire for real."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from controller.drivers.conformance import check_driver
from controller.drivers.conformance.bench import RADIUS
from controller.drivers.conformance.suite import CAPTURE, FIRST, LAST
from controller.drivers.registry import OURS
from controller.system.origin import ROOT
from controller.virtual.bench import PeerBench
from controller.virtual.natnet_server import NatNetServer
from controller.virtual.registry import CAPTURE_PEERS, VALVE_PEERS
from tests.controller.drivers import marker_source
from tests.controller.drivers.capture.test_lsl import CONFIGURATION

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

EVERY_CHECK = [(name, "shown") for name in (*FIRST, *CAPTURE, *LAST)]
HERE = {"lsl", "motioncapture", "ros2"}
NEEDS_HARDWARE = {"nidaq"}
LSL = """
import json, sys, time
from controller.drivers.conformance import check_driver, trial
from tests.controller.drivers.conformance.test_conformance_peers import ProcessBench

trial.MARGIN = float(sys.argv[1])
stream = f"rods-{time.monotonic_ns()}"
bench = ProcessBench("lsl", stream, {"stream": stream, "scale": 0.001})
try:
    print(json.dumps([row.model_dump() for row in check_driver("lsl", {}, bench)]))
finally:
    bench.unplug()
"""
QUICK = """
[tuning]
TimeProbeInterval = 0.01
TimeUpdateMinProbes = 2
"""
"""Each open compares clocks, in 0.2 s instead of 0.6 s, though the machine may pause for most of its questions."""
MARGIN = 1.0
"""Other tests run beside these [s]."""


class ProcessBench:
    """A device in a process of its own: killed as by a power cut, and stopped as one that hangs."""

    def __init__(self, kind: str, place: str, options: dict[str, str | int]) -> None:
        self.options = options
        self._command = [sys.executable, str(marker_source.__file__), kind, place, str(RADIUS)]
        self._process: subprocess.Popen[bytes] | None = None

    def plug(self) -> None:
        if self._process is not None:
            os.kill(self._process.pid, signal.SIGCONT)
            return
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE)
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"

    def unplug(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def silence(self) -> None:
        assert self._process is not None
        os.kill(self._process.pid, signal.SIGSTOP)

    def driven(self) -> None:
        return None


class OptitrackBench(PeerBench):
    """Our emulator for Motive, by multicast, as the back end of the package motioncapture wants it."""

    def __init__(self) -> None:
        super().__init__("natnet")
        self.peer = NatNetServer("4.1", ("tip",), "239.255.42.99")

    @property
    def options(self) -> dict[str, str | int]:
        where = {"interface_ip": self.peer.address, "port_command": self.peer.options["command_port"]}
        settings = [f"{name}={value}" for name, value in where.items()]
        return {"system": "optitrack", "hostname": self.peer.address, "settings": settings}


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.drivers.conformance.trial.MARGIN", MARGIN)


@pytest.fixture
def ros2_bench() -> Iterator[ProcessBench]:
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"127.0.0.1:{free.getsockname()[1]}"
    options: dict[str, str | int] = {"router": address, "topic": f"{marker_source.TOPIC}/**", "label": "tip"}
    bench = ProcessBench("ros2", address, options)
    yield bench
    bench.unplug()


def test_every_driver_of_ours_has_a_peer_or_needs_hardware() -> None:
    assert {*CAPTURE_PEERS, *VALVE_PEERS} | HERE | NEEDS_HARDWARE == set(OURS)


@pytest.mark.skipif(find_spec("rosbags") is None, reason="the package rosbags is not installed")
def test_ros2_passes_every_check_against_a_zenoh_session_that_puts_cdr(ros2_bench: ProcessBench) -> None:
    rows = check_driver("ros2", {}, ros2_bench)
    assert [(row.check, row.answer) for row in rows] == EVERY_CHECK, rows


@pytest.mark.skipif(find_spec("motioncapture") is None, reason="the package motioncapture is not installed")
def test_motioncapture_passes_every_check_against_our_emulator_for_motive() -> None:
    bench = OptitrackBench()
    try:
        rows = check_driver("motioncapture", {}, bench)
    finally:
        bench.close()
    assert [(row.check, row.answer) for row in rows] == EVERY_CHECK, rows


@pytest.mark.skipif(find_spec("pylsl") is None, reason="the package pylsl is not installed")
def test_lsl_passes_every_check_against_an_outlet_of_pylsl(tmp_path: Path) -> None:
    """In a process of its own, for LSL is configured once."""
    (tmp_path / "lsl.cfg").write_text(CONFIGURATION + QUICK)
    done = subprocess.run(
        [sys.executable, "-c", LSL, str(MARGIN)],
        env=os.environ | {"LSLAPICFG": str(tmp_path / "lsl.cfg")},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    rows = json.loads(done.stdout)
    assert [(row["check"], row["answer"]) for row in rows] == EVERY_CHECK, rows
