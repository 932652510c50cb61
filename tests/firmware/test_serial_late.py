"""Answers that come late, at far ends that hold them back until they are told to send them."""

import socket
import struct
import termios
import time
from typing import Any

import numpy as np
import pytest
import serial.serialposix

from controller.drivers.device import Reading
from controller.drivers.hardware import HardwareDriver
from controller.drivers.valves.serial_board import frames
from controller.drivers.valves.serial_board.driver import Line
from controller.drivers.valves.serial_board.pending import SILENCE_NS, WINDOW, Pending
from controller.schema.hardware import DriverStatus, Hardware, MotionCapture, Valves
from controller.schema.layout import record_dtype
from controller.schema.messages import ValveCommand
from controller.schema.parameters import RigParameters, SafetyLimits
from tests.controller.drivers.effort import Waits
from tests.firmware.conftest import VENT, Begin, answer, outlet, wait_for
from tests.firmware.far_end import FarEnd, hello_reply, state

pytestmark = pytest.mark.alone


class Withheld:
    """Answers hellos, and commands while it is `open`; the bodies of the others are kept."""

    def __init__(self, opened: bool = False) -> None:
        self.opened, self.kept = opened, list[bytes]()

    def __call__(self, asked: bytes) -> bytes:
        if asked[1] == 1:
            return hello_reply(asked)
        if self.opened:
            return state(asked)
        self.kept.append(asked)
        return b""


def arrived(line: Line | None) -> bool:
    """Whether something waits to be read."""
    assert line is not None
    return bool(line._poll.poll(0))


def state_of(sequence: int) -> frames.State:
    return frames.State(sequence, 0, 0, 0, 1, 0, 0, 0, (0, 0, 0, 0))


def test_a_late_answer_is_matched_used_and_counted(far_end: Begin) -> None:
    board = Withheld()
    end, device = far_end(board)
    device.open()
    assert device.exchange(VENT, 0.1) is None
    end.say(state(board.kept[0], pressure=7777))
    assert wait_for(lambda: arrived(device._line))
    late = device.exchange(VENT, 0.1)
    assert late is not None and late.pressures.tolist() == [7777.0] * 4
    assert (device.late, device.rejected) == (1, 0)
    board.opened = True
    assert answer(device, VENT).pressures.tolist() == [1000.0] * 4


def test_a_late_answer_tells_when_the_pressures_were_read_not_when_it_came(far_end: Begin) -> None:
    held: list[bytes] = []
    holds = False

    def now_us() -> int:
        return time.monotonic_ns() // 1000 % 2**32

    def answers(asked: bytes) -> bytes:
        if asked[1] == 1:
            return hello_reply(asked)
        said = bytearray(frames.opened(state(asked).strip(b"\0")))
        struct.pack_into("<II", said, 8, now_us(), now_us())
        if not holds:
            return frames.sealed(bytes(said))
        held.append(frames.sealed(bytes(said)))
        return b""

    end, device = far_end(answers)
    device.open()
    answer(device, VENT)
    holds = True
    assert device.exchange(VENT, 0.1) is None
    assert wait_for(lambda: len(held) > 0)
    between = time.monotonic_ns()
    time.sleep(0.2)
    end.say(held[0])
    assert wait_for(lambda: arrived(device._line))
    late = device.exchange(VENT, 0.1)
    assert late is not None and late.t_ns < between + 100_000_000


def test_an_answer_that_a_paused_program_reads_late_came_in_time(far_end: Begin) -> None:
    _, device = far_end(Withheld(opened=True))
    device.open()
    first = device.exchange(VENT, 0.0)
    assert wait_for(lambda: arrived(device._line) or first is not None)
    time.sleep(5 * device.options.timeout)
    assert device.exchange(VENT, 0.0) is not None or first is not None
    assert (device.late, device.notice) == (0, "")


def test_answers_that_are_older_than_one_before_are_not_taken(far_end: Begin) -> None:
    board = Withheld()
    end, device = far_end(board)
    device.open()
    assert [device.exchange(VENT, 0.1) for _ in range(3)] == [None] * 3
    assert wait_for(lambda: len(board.kept) == 3)
    end.say(state(board.kept[1], pressure=2222))
    end.say(state(board.kept[0], pressure=1111) + state(board.kept[1], pressure=2222))
    assert answer(device, VENT).pressures.tolist() == [2222.0] * 4
    assert device.exchange(VENT, 0.1) is None
    assert (device.rejected, device.late) == (2, 1)


def test_late_answers_are_not_lost_ones_and_lost_ones_are(far_end: Begin) -> None:
    board = Withheld()
    end, device = far_end(board)
    device.open()
    for _ in range(4):
        device.exchange(VENT, 0.1)
    assert wait_for(lambda: len(board.kept) == 4)
    end.say(state(board.kept[0]) + state(board.kept[1]))
    first = answer(device, VENT).number
    end.say(state(board.kept[3]))
    assert answer(device, VENT).number - first == 2, "one between them was lost"
    assert first == 2


def test_a_line_whose_answers_are_late_says_after_how_long_and_how_many() -> None:
    pending = Pending(0.01)
    for n in range(20):
        pending.sent(n, 0, n * 20_000_000)
        pending.line_was_empty(n * 20_000_000 + 10_000_000)
        assert pending.answered(state_of(n), n * 20_000_000 + 15_000_000) is not None
    assert pending.notice == "answers come after 15 ms, timeout is 10 ms"
    assert pending.late == 20


def test_one_late_answer_in_a_while_is_counted_and_no_state() -> None:
    pending = Pending(0.01)
    for n in range(200):
        pending.sent(n, 0, n * 20_000_000)
        if n % 25 == 0:
            pending.line_was_empty(n * 20_000_000 + 11_000_000)
        assert pending.answered(state_of(n), n * 20_000_000 + 12_000_000) is not None
    assert (pending.late, pending.notice) == (8, "")


def test_what_is_said_of_late_answers_ends_when_they_come_in_time() -> None:
    pending = Pending(0.01)
    for n in range(300):
        pending.sent(n, 0, n * 20_000_000)
        if n < 100:
            pending.line_was_empty(n * 20_000_000 + 11_000_000)
        pending.answered(state_of(n), n * 20_000_000 + 12_000_000)
        assert (pending.notice != "") == (4 <= n < 190)


def test_a_line_too_slow_for_its_commands_is_not_filled_with_them(far_end: Begin) -> None:
    end, device = far_end(Withheld())
    device.open()
    hellos, begun = end.frames, time.monotonic_ns()
    for _ in range(60):
        device.exchange(outlet(50e3), 0.0)
    silences = (time.monotonic_ns() - begun) // SILENCE_NS
    time.sleep(0.05)
    assert WINDOW <= device._number - hellos <= WINDOW + silences + 1


def test_to_vent_and_to_cut_never_wait_for_a_slow_line(far_end: Begin) -> None:
    board = Withheld()
    _, device = far_end(board)
    device.open()
    for _ in range(2 * WINDOW):
        device.exchange(outlet(50e3), 0.0)
    for wanted in (VENT, outlet(vent=True, cut=True)):
        before = device._number
        device.exchange(wanted, 0.0)
        assert device._number == before + 1
    assert wait_for(lambda: len(board.kept) >= WINDOW + 2)
    assert [asked[8] for asked in board.kept][-2:] == [frames.VENT, frames.VENT | frames.CUT]


def test_silence_lets_the_next_command_go_so_that_a_boards_watchdog_is_fed() -> None:
    pending = Pending(0.01)
    for n in range(WINDOW):
        assert not pending.full(n)
        pending.sent(n, 0, n)
    assert pending.full(WINDOW)
    assert not pending.full(WINDOW + SILENCE_NS)


def test_a_board_that_answers_hellos_after_the_next_was_asked_is_opened(far_end: Begin) -> None:
    _, device = far_end(Withheld(opened=True), delay=0.25, hello_timeout=5.0, timeout=0.2)
    device.open()
    assert device.board is not None
    assert answer(device, VENT).pressures.tolist() == [1000.0] * 4
    assert wait_for(lambda: device.exchange(VENT, 0.1) is not None and device.late > 5)
    assert device.notice.endswith("timeout is 200 ms")


def test_no_wait_for_an_answer_is_longer_than_half_the_boards_watchdog(far_end: Begin) -> None:
    _, device = far_end(Withheld(), timeout=0.2)
    device.open()
    assert device._line is not None and device.board is not None
    waits = Waits(device._line._poll)
    device._line._poll = waits  # type: ignore[assignment]
    device.exchange(VENT, 0.1)
    assert 0.0 < max(waits.asked) <= 0.5e-3 * device.board.watchdog_ms < 0.1


def hardware_of(end: FarEnd, pressures_lost: float) -> HardwareDriver:
    """A rig whose valves are at `end` and whose camera is not there."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        camera = {"port": free.getsockname()[1], "sender": "127.0.0.1"}
    rig = Hardware(
        motion_capture=MotionCapture(driver="json", options=camera, rods=(10,)),
        valves=Valves(driver="serial", options={"port": end.port, "timeout": 0.01}),
    )
    return HardwareDriver(RigParameters(limits=SafetyLimits(pressures_lost=pressures_lost)), rig)


def valves_of(driver: HardwareDriver) -> DriverStatus:
    return next(one for one in driver.status() if one.role == "valves")


@pytest.mark.parametrize(("pressures_lost", "arms"), [(10.0, True), (0.001, False)])
def test_late_answers_are_the_devices_state_and_keep_no_one_from_arming_but_old_pressures_do(
    far_end: Begin, pressures_lost: float, arms: bool
) -> None:
    end, _ = far_end(Withheld(opened=True), delay=0.06)
    driver = hardware_of(end, pressures_lost)
    command = np.zeros(1, record_dtype(ValveCommand))
    command["vent"] = True
    driver.start(lambda record: None, lambda: None, lambda: command[0])
    try:
        assert wait_for(lambda: valves_of(driver).detail.startswith("answers come after "), 20.0)
        seen = valves_of(driver)
        assert seen.state == "running" and seen.detail.endswith("ms, timeout is 10 ms") and seen.late > 0
        assert ("valves" not in driver.unready()) == arms
        assert arms or "limits.pressures_lost = 1 ms" in driver.unready()
    finally:
        driver.stop()


class Kernel:
    """Stands where the system keeps a port's serial_struct, which no pseudo-terminal has: its flags are word 4."""

    def __init__(self, flags: int) -> None:
        self.words = [7] * 32
        self.words[4] = flags
        self._real = serial.serialposix.fcntl.ioctl

    def ioctl(self, file: int, request: int, *data: Any) -> Any:
        if request == termios.TIOCGSERIAL:
            data[0][:] = type(data[0])("i", self.words)
        elif request == termios.TIOCSSERIAL:
            self.words = list(data[0])
        else:
            return self._real(file, request, *data)


def test_the_port_is_told_to_hold_nothing_back(far_end: Begin, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = Kernel(flags=0x10)
    monkeypatch.setattr(serial.serialposix.fcntl, "ioctl", kernel.ioctl)
    end, _ = far_end(Withheld(opened=True))
    Line(end.port, 115200).close()
    low_latency = 0x2000  # ASYNC_LOW_LATENCY of linux/tty_flags.h: an FTDI adapter's latency timer becomes 1 ms
    assert kernel.words == [*[7] * 4, 0x10 | low_latency, *[7] * 27]


def test_a_port_without_that_mode_is_opened_all_the_same(far_end: Begin) -> None:
    _, device = far_end(Withheld(opened=True))
    device.open()
    read = answer(device, VENT)
    assert isinstance(read, Reading)
