"""The firmware's core, millisecond by millisecond: its time is ours here, and no other program's."""

import ctypes
from collections.abc import Sequence

import numpy as np
import pytest

from controller.drivers.valves.serial_board import frames
from controller.drivers.valves.serial_board.frames import BROKEN, RAW, VENT, Cutter, HelloReply, State
from controller.virtual.firmware import FLAGS, build, firmware_folder

pytestmark = [pytest.mark.process, pytest.mark.keyed("firmware")]

CHANNELS = 8
ALL = 0xFF
MS = 1000
SLEW = 20_000
"""Of the host's configuration [Pa/ms]."""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    program = tmp_path_factory.mktemp("core") / "core.so"
    build(firmware_folder() / "host" / "library.cpp", program, (*FLAGS, "-Werror", "-shared", "-fPIC"))
    return ctypes.CDLL(str(program))


class Core:
    """A board that has just started; `now` is its clock [us]."""

    def __init__(self, library: ctypes.CDLL, now: int) -> None:
        self._lib, self.now, self.sequence = library, now, 100
        self.pressures = [0] * CHANNELS
        self.e_stop = False
        library.start(1, ctypes.c_uint32(now))
        self.step()

    def step(self, milliseconds: int = 1) -> None:
        for _ in range(milliseconds):
            self.now = (self.now + MS) % 2**32
            shown = (ctypes.c_int32 * CHANNELS)(*self.pressures)
            self._lib.step(ctypes.c_uint32(self.now), shown, int(self.e_stop))

    def hear(self, wire: bytes) -> HelloReply | State | None:
        out = (ctypes.c_uint8 * 100)()
        size = self._lib.receive(wire, len(wire), ctypes.c_uint32(self.now), out)
        found = Cutter().feed(bytes(out[:size]))
        return found[0] if found else None

    def command(self, wanted: int, targets: Sequence[int] = (0,) * CHANNELS, ahead: int = 1) -> State | None:
        self.sequence = (self.sequence + ahead) % 65536
        found = self.hear(frames.command(self.sequence, 0, wanted, 0 if wanted & VENT else ALL, targets))
        assert not isinstance(found, HelloReply)
        return found

    def drive(self, target: int, milliseconds: int, wanted: int = 0) -> None:
        """Say so every 2 ms."""
        for _ in range(milliseconds // 2):
            self.command(wanted, [target] * CHANNELS)
            self.step(2)

    @property
    def vented(self) -> bool:
        driven = [self._lib.opening(i) for i in range(CHANNELS)] != [-32767] * CHANNELS
        assert self.says("outputs") & frames.VENTED == 0 or not driven
        return bool(self.says("outputs") & frames.VENTED)

    def says(self, what: str) -> int:
        return int(getattr(self._lib, what)())

    def opening(self, channel: int = 0) -> int:
        return int(self._lib.opening(channel))

    def setpoint(self, channel: int = 0) -> int:
        return int(self._lib.setpoint(channel))


@pytest.fixture(params=[0, 2**32 - 150 * MS], ids=["early", "before its clock wraps"])
def core(library: ctypes.CDLL, request: pytest.FixtureRequest) -> Core:
    return Core(library, request.param)


@pytest.fixture
def driving(core: Core) -> Core:
    core.command(VENT)
    core.drive(100_000, 100)
    assert not core.vented
    return core


def test_the_watchdog_vents_in_the_101st_millisecond(driving: Core) -> None:
    driving.command(0, [100_000] * CHANNELS)
    driving.step(100)
    assert not driving.vented
    driving.step()
    assert driving.vented
    assert driving.says("reasons") == frames.WATCHDOG


def test_after_the_watchdog_nothing_moves_before_a_vent(driving: Core) -> None:
    driving.step(101)
    driving.drive(100_000, 200)
    assert driving.vented
    driving.command(VENT)
    driving.drive(100_000, 2)
    assert not driving.vented


def test_bad_frames_do_not_feed_the_watchdog(driving: Core) -> None:
    for _ in range(110):
        driving.hear(b"\0\x05\x01\x02\x03\x04\0")
        driving.step()
    assert driving.says("reasons") == frames.WATCHDOG
    assert driving.says("rejected") == 110


def test_repeated_and_old_commands_do_not_feed_the_watchdog(driving: Core) -> None:
    for ahead in (0, -1, -1000, 32768):
        assert driving.command(0, [1000] * CHANNELS, ahead) is None
        driving.sequence = (driving.sequence - ahead) % 65536
    assert driving.says("rejected") == 4
    assert driving.command(0, [1000] * CHANNELS, 32767) is not None


def test_a_hello_stops_the_board(driving: Core) -> None:
    assert isinstance(driving.hear(frames.hello(5, 0)), HelloReply)
    assert driving.vented
    driving.sequence = 5
    driving.drive(100_000, 20)
    assert driving.vented
    assert driving.says("reasons") == frames.GREETED


def test_a_hello_of_another_version_learns_ours_and_changes_nothing(driving: Core) -> None:
    assert isinstance(driving.hear(frames.sealed(b"\x02\x01" + bytes(6))), HelloReply)
    assert not driving.vented
    assert driving.says("rejected") == 1


def test_setpoints_rise_and_fall_no_faster_than_the_slew(driving: Core) -> None:
    for target in (300_000, 0, 1_200_000, -1_200_000):
        before = driving.setpoint()
        for _ in range(40):
            driving.command(0, [target] * CHANNELS)
            driving.step()
            assert abs(driving.setpoint() - before) <= SLEW
            assert 0 <= driving.setpoint() <= 300_000
            before = driving.setpoint()
        assert before == min(max(target, 0), 300_000)


def test_a_setpoint_begins_at_the_atmosphere_after_each_vent(driving: Core) -> None:
    driving.command(VENT)
    driving.command(0, [100_000] * CHANNELS)
    driving.step()
    assert driving.setpoint() == SLEW


def test_the_third_reading_above_the_limit_vents_and_cuts(driving: Core) -> None:
    driving.pressures[5] = 340_001
    driving.step(2)
    assert not driving.vented
    driving.step()
    assert driving.vented
    assert driving.says("outputs") & frames.SUPPLY_CUT
    assert driving.says("reasons") == frames.OVER_PRESSURE


def test_no_air_comes_in_before_a_host_has_vented(core: Core) -> None:
    assert core.says("outputs") & frames.SUPPLY_CUT
    core.hear(frames.hello(core.sequence, 0))
    core.drive(100_000, 20)
    assert core.vented and core.says("outputs") & frames.SUPPLY_CUT
    core.command(VENT)
    core.step()
    assert not core.says("outputs") & frames.SUPPLY_CUT


def test_one_wrong_reading_stops_nothing(driving: Core) -> None:
    for shown in (10**9, 0, BROKEN, 0) * 10:
        driving.pressures[3] = shown
        driving.drive(100_000, 2)
        driving.pressures[3] = 0
        driving.step()
    assert not driving.vented


def test_the_hardware_stop_acts_in_the_next_millisecond(driving: Core) -> None:
    driving.e_stop = True
    driving.step()
    assert driving.vented
    assert driving.says("outputs") & frames.SUPPLY_CUT


def test_a_vent_acts_at_once_and_whatever_else_the_frame_says(driving: Core) -> None:
    driving.sequence += 1
    driving.hear(frames.command(driving.sequence, 0, VENT, ALL, [100_000] * CHANNELS))
    assert driving.vented


def test_no_setpoint_becomes_an_opening(driving: Core) -> None:
    driving.command(RAW, [30_000] * CHANNELS)
    assert driving.vented
    driving.step()
    assert (driving.opening(), driving.setpoint()) == (30_000, 0)
    driving.command(0, [30_000] * CHANNELS)
    assert driving.vented
    driving.step()
    assert driving.setpoint() == SLEW


def test_the_integral_does_not_grow_while_the_valve_is_at_its_end(driving: Core) -> None:
    driving.drive(300_000, 2000)  # nothing fills these chambers
    assert driving.opening() == 32767
    driving.pressures = [299_000] * CHANNELS
    driving.drive(200_000, 100)
    assert driving.opening() < 0


@pytest.mark.parametrize("gap", [0.15, 0.9])
def test_the_loop_holds_a_chamber_without_a_leak_and_with_one(driving: Core, gap: float) -> None:
    p = np.zeros(CHANNELS)
    leak = np.linspace(0.0, gap, CHANNELS)
    for _ in range(1500):
        driving.command(0, [150_000] * CHANNELS)
        driving.step()
        openings = np.array([driving.opening(i) for i in range(CHANNELS)]) / 32767
        flow = np.where(openings > 0, openings * (400_000 - p), openings * p) - leak * p * 0.5
        p = p + flow * 1e-3 / 0.03
        driving.pressures = [round(one) for one in p]
    assert p == pytest.approx(np.full(CHANNELS, 150_000), rel=0.02)
