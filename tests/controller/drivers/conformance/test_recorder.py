"""A driver of which nothing is known, on the wire of a device that is there: what is shown, and what never is."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from controller.drivers.conformance import Recorder, Row, check_driver
from controller.drivers.conformance.suite import VALVES
from controller.drivers.registry import driver_class
from controller.drivers.valves.udp_layout import CUT, RAW, VENT, unpack_command
from controller.errors import ParameterError
from controller.schema.hardware import CHANNELS
from controller.virtual.bench import Chambers
from controller.virtual.board import BoardPeer
from controller.virtual.firmware import compiler
from controller.virtual.modbus_server import ModbusPeer
from controller.virtual.peers import Drive
from controller.virtual.udp_target import UdpTargetPeer
from tests.controller.drivers.conformance.labboard import DRIVER, PEER, made

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]

Good: Any = made(DRIVER, "LabBoard")
Peer: Any = made(PEER, "LabPeer")
CANNOT_KNOW = {"speaks pascal", "sends nothing impossible"}
"""Of bytes whose meaning no one told, and of sensors that may be wrong as the setpoints are."""


class SendsNan(Good):
    """The template, without the clause that keeps what is not finite from leaving."""

    def exchange(self, outlet: Any, timeout: float) -> Any:
        numbers = outlet.vent or outlet.cut or np.isfinite(outlet.pressures).all()
        return super().exchange(outlet, timeout) if numbers else self.send_nan(outlet, timeout)

    def send_nan(self, outlet: Any, timeout: float) -> Any:
        self._socket.sendall(b"S " + b" ".join(f"{p:.0f}".encode() for p in outlet.pressures) + b"\n")


class SendsNanAsFloats(SendsNan):
    def send_nan(self, outlet: Any, timeout: float) -> Any:
        self._socket.sendall(b"B" + outlet.pressures.astype(">f4").tobytes())


class SendsTooMuch(Good):
    def exchange(self, outlet: Any, timeout: float) -> Any:
        if outlet.vent or outlet.pressures[0] != 1e12:
            return super().exchange(outlet, timeout)
        self._socket.sendall(f"S {outlet.pressures[0] / 1e3:.1f} kPa\n".encode())
        return None


class SwallowsNan(Good):
    def exchange(self, outlet: Any, timeout: float) -> Any:
        return super().exchange(outlet, timeout) if np.isfinite(outlet.pressures).all() else None


class ReadsAndWritesPsi(Good):
    """Its sensors agree with its setpoints, and both are wrong by the same factor."""

    def exchange(self, outlet: Any, timeout: float) -> Any:
        found = super().exchange(outlet._replace(pressures=outlet.pressures * 2.0), timeout)
        return found and found._replace(pressures=found.pressures / 2.0)


class HasBrokenSensors(Good):
    def exchange(self, outlet: Any, timeout: float) -> Any:
        found = super().exchange(outlet, timeout)
        return found and found._replace(pressures=np.full(4, np.nan))


class LosesItsSensors(Good):
    """They say nan as soon as it vents."""

    def exchange(self, outlet: Any, timeout: float) -> Any:
        found = super().exchange(outlet, timeout)
        return found._replace(pressures=np.full(4, np.nan)) if found and outlet.vent else found


class FeedsTheBoardAfterClose(Peer):
    """Its watchdog is a part of its connection, and ends with it."""

    def _serve(self) -> None:
        self._look = lambda: None
        super()._serve()

    def _talk(self, connection: Any, thread: Any) -> None:
        self._look = lambda: Peer._look(self)
        super()._talk(connection, thread)
        self._look = lambda: None


def decode(sent: bytes) -> Drive | None:
    """By the board's manual: the newest whole line."""
    found = None
    for line in re.findall(rb"(.*)\n", sent):
        words, pressures = line.split(), np.zeros(CHANNELS)
        pressures[:4] = [float(word) for word in words[1:5]] or [0.0] * 4
        found = Drive(pressures, np.zeros(CHANNELS), False, words[0] == b"V", False)
    return found


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.drivers.conformance.watchdog.LOST_LIMIT", 0.5)
    monkeypatch.setattr("controller.drivers.conformance.frames.SPAN", 0.2)
    monkeypatch.setattr("controller.drivers.conformance.valves.SETTLE", 1.0)


def board(kind: Any = Peer, watchdog: float = 0.1) -> Any:
    chambers = Chambers()
    found = kind({}, chambers.pressures, chambers.take)
    found.chambers, found.watchdog = chambers, watchdog
    found.plug()
    return found


@pytest.fixture
def device() -> Iterator[Any]:
    found = board()
    yield found
    found.close()


def checked(kind: Any, device: Any, only: tuple[str, ...] = (), **more: Any) -> dict[str, Row]:
    """By way of a recorder; `more`: its `decode`, and `drive`."""
    drive = more.pop("drive", True)
    recorder = Recorder(kind.Options(**device.options).model_dump(), **more)
    try:
        return {row.check: row for row in check_driver(kind, device.options, recorder, drive, only)}
    finally:
        recorder.close()


def one(kind: Any, device: Any, check: str, **more: Any) -> Row:
    return checked(kind, device, (check,), **more)[check]


def test_driven_and_recorded_all_is_shown_but_what_the_bytes_mean(device: Any) -> None:
    rows = checked(Good, device)
    assert {name: row for name, row in rows.items() if row.answer != "shown" and name not in CANNOT_KNOW} == {}
    assert {rows[name].answer for name in CANNOT_KNOW} == {"not shown"}


def test_with_what_the_bytes_mean_all_is_shown(device: Any) -> None:
    rows = checked(Good, device, decode=decode)
    assert {name: row for name, row in rows.items() if row.answer != "shown"} == {}


def test_driven_without_a_recorder_nothing_is_said_of_what_left(device: Any) -> None:
    for kind in (Good, SendsNan):
        (row,) = check_driver(kind, device.options, drive=True, only=["sends nothing impossible"])
        assert row.answer == "not shown" and "--record" in row.detail


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (SendsNan, r"a command of nan leaves as it is: b'S nan "),
        (SendsNanAsFloats, r"a command of nan leaves as it is: b'B\\x7f\\xc0\\x00\\x00"),
        (SendsTooMuch, r"a command of 1000000000000\.0 leaves as it is: b'S 1000000000\.0 kPa"),
    ],
)
def test_what_leaves_as_it_was_fails_and_never_reaches_the_board(device: Any, kind: Any, text: str) -> None:
    heard: list[Drive] = []
    device._take = lambda drive: heard.append(drive) or device.chambers.take(drive)
    row = one(kind, device, "sends nothing impossible", drive=False)
    assert row.answer == "failed" and re.search(text, row.detail), row.detail
    assert heard and all(drive.vent for drive in heard)


def test_a_command_that_vanishes_in_the_driver_is_not_shown_to_be_safe(device: Any) -> None:
    row = one(SwallowsNan, device, "sends nothing impossible", decode=decode)
    assert row.answer == "not shown" and "was taken, and nothing left" in row.detail


def test_units_that_are_wrong_both_ways_agree_with_themselves_and_fail_against_the_wire(device: Any) -> None:
    assert one(ReadsAndWritesPsi, device, "follows setpoints").answer == "shown"
    assert one(ReadsAndWritesPsi, device, "speaks pascal").answer == "not shown"
    row = one(ReadsAndWritesPsi, device, "speaks pascal", decode=decode)
    assert row.answer == "failed" and "the valves are told" in row.detail


def test_nan_is_never_taken_for_empty(device: Any) -> None:
    assert one(HasBrokenSensors, device, "frames are well formed").answer == "not shown"
    for check in ("vents when told", "vents when the host dies"):
        assert one(HasBrokenSensors, device, check).answer == "failed"
        row = one(LosesItsSensors, device, check)
        assert row.answer == "failed" and "the sensors say [nan nan nan nan]" in row.detail, row


@pytest.mark.parametrize("recorded", [True, False])
def test_the_watchdog_of_a_real_board_is_tried_on_it(device: Any, recorded: bool) -> None:
    def answer() -> Row:
        if recorded:
            return one(Good, device, "vents when the host dies")
        return check_driver(Good, device.options, drive=True, only=["vents when the host dies"])[0]

    assert answer().answer == "shown"
    device.watchdog = 60.0
    row = answer()
    assert row.answer == "failed" and "with nothing closed, after 0.5 s" in row.detail
    assert device.chambers.drive.vent


def test_a_watchdog_that_ends_with_the_connection_fails() -> None:
    device = board(FeedsTheBoardAfterClose)
    try:
        row = one(Good, device, "vents when the host dies")
    finally:
        device.close()
    assert row.answer == "failed" and "closed and opened again, after 0.5 s" in row.detail


def test_a_board_that_was_not_driven_is_not_said_to_vent(device: Any) -> None:
    rows = checked(Good, device, drive=False)
    assert {name for name in VALVES if rows[name].answer != "not shown"} == set()
    assert rows["ends when closed"].answer == rows["survives a loss"].answer == "shown"


def decode_udp(sent: bytes) -> Drive | None:
    command = unpack_command(sent)
    if command is None:
        return None
    pressures, openings = np.zeros(CHANNELS), np.zeros(CHANNELS)
    pressures[:4], openings[:4] = command.pressures, command.openings
    flags = command.flags
    return Drive(pressures, openings, bool(flags & RAW), bool(flags & VENT), bool(flags & CUT))


@pytest.mark.parametrize(
    ("driver", "kind", "more"),
    [
        ("udp", UdpTargetPeer, {"decode": decode_udp}),
        ("modbus", ModbusPeer, {}),
        pytest.param("serial", BoardPeer, {}, marks=pytest.mark.skipif(compiler() is None, reason="no compiler")),
    ],
)
def test_our_drivers_fail_nothing_on_a_wire_that_is_recorded(
    driver: str, kind: Any, more: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("controller.drivers.conformance.trial.MARGIN", 1.0)  # other tests run beside this one
    monkeypatch.setattr("controller.drivers.conformance.watchdog.LOST_LIMIT", 1.5)  # a terminal's own may be 0.5 s
    chambers = Chambers()
    device = kind(chambers.pressures, chambers.take)
    device.plug()
    try:
        rows = checked(driver_class(driver), device, **more)
    finally:
        device.close()
    unknown = set() if more else CANNOT_KNOW
    assert {name: row for name, row in rows.items() if row.answer != "shown" and name not in unknown} == {}


def test_a_device_at_no_known_wire_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"options stream: none of host, .* no port, "):
        Recorder({"stream": "rods"})
