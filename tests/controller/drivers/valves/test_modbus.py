import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from controller.drivers.device import DeviceError
from controller.drivers.valves.modbus.driver import ModbusValves
from controller.drivers.valves.modbus.registers import words_of
from controller.drivers.valves.modbus.wire import Wire
from controller.errors import ParameterError
from controller.virtual import modbus_server
from controller.virtual.modbus_server import ModbusPeer
from tests.controller.drivers.commands import ANSWER_S, SETPOINTS, Plant, vented, wanted
from tests.controller.drivers.effort import Waits
from tests.controller.drivers.valves.clock import Clock

LISTED = {"map": "registers", "pressure_registers": [1, 2, 3, 4], "setpoint_registers": [11, 12, 13, 14]}
"""Registers of a device that is no VTEM."""


@pytest.fixture
def valves(peer: ModbusPeer) -> Iterator[ModbusValves]:
    valves = valves_at(peer)
    yield valves
    valves.close()


def valves_at(peer: ModbusPeer, chambers: tuple[int, ...] = (0, 1, 2, 3), **options: Any) -> ModbusValves:
    valves = ModbusValves(ModbusValves.Options(**(peer.options | options)), chambers, False)
    valves.open()
    return valves


def test_each_chamber_has_its_own_port_and_sensor(peer: ModbusPeer, plant: Plant) -> None:
    valves = valves_at(peer, (9, 2, 0, 1))
    reading = valves.exchange(wanted(), ANSWER_S)
    valves.close()
    assert reading is not None and reading.stopped == ""
    assert reading.pressures.tolist() == [9e3, 2e3, 0.0, 1e3]
    assert plant.drive.pressures[[9, 2, 0, 1]].tolist() == SETPOINTS.tolist()
    assert plant.drive.pressures.sum() == SETPOINTS.sum()  # nothing else is driven


def test_pressures_below_the_atmosphere_keep_their_sign(valves: ModbusValves, plant: Plant) -> None:
    plant.sensed[:4] = -50e3, -100.0, 0.0, 700e3
    reading = valves.exchange(wanted(np.array([-40e3, 0.0, 0.0, 0.0])), ANSWER_S)
    assert reading is not None and reading.pressures.tolist() == [-50e3, -100.0, 0.0, 700e3]
    assert plant.drive.pressures[0] == -40e3


def test_one_request_writes_and_reads_everything(peer: ModbusPeer) -> None:
    valves = valves_at(peer, dump_register=-1)
    before = peer.requests
    valves.exchange(wanted(), ANSWER_S)
    valves.close()
    assert peer.requests - before == 2  # the write and the read of one function 23


def test_a_device_without_function_23_is_asked_twice(peer: ModbusPeer, plant: Plant) -> None:
    peer.unknown = {23}
    valves = valves_at(peer)
    reading = valves.exchange(wanted(), ANSWER_S)
    valves.close()
    assert reading is not None and reading.pressures[3] == 3e3
    assert plant.drive.pressures[:4].tolist() == SETPOINTS.tolist()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_vents(valves: ModbusValves, plant: Plant, value: float) -> None:
    valves.exchange(wanted(), ANSWER_S)
    valves.exchange(wanted(np.array([value, 1e5, 1e5, 1e5])), ANSWER_S)
    assert plant.drive.vent and not plant.drive.pressures.any()


def test_setpoints_beyond_the_limits_are_sent_as_the_limits(peer: ModbusPeer, plant: Plant) -> None:
    valves = valves_at(peer, setpoint_max=300e3, setpoint_min=-20e3)
    valves.exchange(wanted(np.array([1e12, -1e12, 299.96e3, 0.0])), ANSWER_S)
    valves.close()
    assert plant.drive.pressures[:4].tolist() == [300e3, -20e3, 300e3, 0.0]


@pytest.mark.parametrize("cut", [False, True])
def test_a_vented_command_zeroes_setpoints_and_opens_the_dump_valve(
    valves: ModbusValves, plant: Plant, cut: bool
) -> None:
    valves.exchange(wanted(), ANSWER_S)
    assert not plant.drive.vent
    valves.exchange(vented(cut), ANSWER_S)
    assert plant.drive.vent and plant.drive.cut and not plant.drive.pressures.any()


def test_the_terminal_vents_by_its_own_watchdog_when_the_host_dies(
    peer: ModbusPeer, plant: Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    valves = valves_at(peer, watchdog=0.15)
    clock = Clock(monkeypatch, modbus_server)
    valves.exchange(wanted(), ANSWER_S)
    clock.pass_by(0.15 - 1e-6)
    assert not plant.drive.vent
    clock.pass_by(2e-6)
    assert plant.drive.vent
    reading = valves.exchange(wanted(), ANSWER_S)
    assert reading is not None and "slot 0 is ready, its app does not run" in reading.stopped
    valves.close()


def test_without_a_watchdog_a_terminal_goes_on_when_the_host_dies(peer: ModbusPeer, plant: Plant) -> None:
    valves = valves_at(peer, watchdog=0.0)
    valves.exchange(wanted(), ANSWER_S)
    valves.close()
    peer.unplug()
    assert plant.vented_within(0.3) == np.inf and plant.drive.pressures[3] == SETPOINTS[3]


def test_after_its_watchdog_it_drives_again_only_once_vented(peer: ModbusPeer, plant: Plant) -> None:
    valves = valves_at(peer, watchdog=0.1)
    valves.exchange(wanted(), ANSWER_S)
    plant.vented_within(1.0)
    for _ in range(20):
        reading = valves.exchange(wanted(), ANSWER_S)
        assert reading is not None and reading.stopped != ""
        assert not plant.drive.pressures.any()
        time.sleep(0.005)
    for _ in range(20):
        valves.exchange(vented(), ANSWER_S)
        time.sleep(0.005)
    reading = valves.exchange(wanted(), ANSWER_S)
    valves.close()
    assert reading is not None and reading.stopped == "" and plant.drive.pressures[3] == SETPOINTS[3]


def test_a_failed_slot_stops_all_and_is_acknowledged_while_vented(
    peer: ModbusPeer, valves: ModbusValves, plant: Plant
) -> None:
    valves.exchange(wanted(), ANSWER_S)
    peer.terminal.fail(1)
    valves.exchange(wanted(), ANSWER_S)
    reading = valves.exchange(wanted(), ANSWER_S)
    assert reading is not None and "slot 1 has failed" in reading.stopped and not plant.drive.pressures.any()
    peer.terminal.mend(1)
    for _ in range(5):
        reading = valves.exchange(wanted(), ANSWER_S)
        assert reading is not None and "slot 1 is not ready" in reading.stopped
    for _ in range(20):
        reading = valves.exchange(vented(), ANSWER_S)
        time.sleep(0.01)
    assert reading is not None and reading.stopped == ""


def test_open_waits_for_an_app_that_does_not_start_and_says_which(peer: ModbusPeer) -> None:
    peer.terminal.fail(1)
    with pytest.raises(DeviceError, match=r"VTEM slot 1 has failed .* after 0.3 s"):
        valves_at(peer, start_time=0.3)


def test_a_terminal_that_would_hold_its_outputs_is_refused_or_set(peer: ModbusPeer) -> None:
    peer.terminal.fail_safe = 1
    with pytest.raises(DeviceError, match="keeps its outputs when its host is lost"):
        valves_at(peer)
    valves_at(peer, fail_safe="ignore").close()
    assert peer.terminal.fail_safe == 1
    valves_at(peer, fail_safe="set").close()
    assert peer.terminal.fail_safe == 0


def test_a_watchdog_register_that_is_not_there_is_named(peer: ModbusPeer) -> None:
    with pytest.raises(
        DeviceError, match=r"watchdog register 46200: the device has no such register .*manual"
    ) as found:
        valves_at(peer, watchdog_register=46200)
    assert "watchdog = 0" not in str(found.value)  # a hint that would switch it off


@pytest.mark.parametrize(
    ("options", "said"),
    [({}, r"no answer when its watchdog was set \(register 46100\)"), ({"watchdog": 0.0}, "no answer when asked for")],
)
def test_a_terminal_that_hangs_is_not_said_to_have_no_watchdog(
    peer: ModbusPeer, options: dict[str, float], said: str
) -> None:
    peer.freeze()
    with pytest.raises(DeviceError, match=said) as found:
        valves_at(peer, connect_time=0.3, **options)
    assert not any(hint in str(found.value) for hint in ("does not take", "goes without", "watchdog = 0", '"ignore"'))


def test_a_watchdog_of_other_times_is_said_with_what_it_keeps(
    peer: ModbusPeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stands in for a terminal of coarser steps: the peer's keeps every time."""
    monkeypatch.setattr(Wire, "read", lambda self, *asked, **more: [600])
    monkeypatch.setattr(Wire, "write", lambda self, *told, **more: True)
    with pytest.raises(DeviceError, match="46100 keeps 600 ms, not 500 ms; chambers would keep their pressure"):
        valves_at(peer, fail_safe="ignore")


def test_another_unit_is_refused(peer: ModbusPeer) -> None:
    with pytest.raises(DeviceError, match="failed"):
        valves_at(peer, unit=7)


def test_nobody_there_is_said() -> None:
    with pytest.raises(DeviceError, match=r"no connection to 127\.0\.0\.1:1: Connection refused"):
        ModbusValves(ModbusValves.Options(host="127.0.0.1", port=1), (0, 1, 2, 3), False).open()


def test_a_device_that_stops_answering_keeps_calls_in_time_and_is_lost(peer: ModbusPeer, valves: ModbusValves) -> None:
    peer.freeze()
    waits = Waits(valves._wire._socket)
    valves._wire._socket = waits  # type: ignore[assignment]
    for _ in range(4):
        assert valves.exchange(wanted(), 0.05) is None
        sending, answer = waits.asked  # a frozen device's system still takes what is sent
        assert sending <= 0.05 >= answer
        waits.asked.clear()
    with pytest.raises(DeviceError, match="no answer to 5 requests"):
        valves.exchange(wanted(), 0.05)
    peer.thaw()
    valves.open()
    assert valves.exchange(wanted(), ANSWER_S) is not None


def test_an_answer_that_comes_too_late_is_dropped_and_counted(peer: ModbusPeer) -> None:
    valves = valves_at(peer, dump_register=-1)
    peer.late = 0.04
    assert valves.exchange(wanted(), 0.02) is None
    time.sleep(0.1)
    peer.late, before = 0.0, valves.rejected
    begun = time.monotonic_ns()
    reading = valves.exchange(wanted(), ANSWER_S)
    valves.close()
    assert reading is not None and begun < reading.t_ns < time.monotonic_ns()
    assert valves.rejected == before + 1


def test_exceptions_are_said_in_words_and_busy_passes(peer: ModbusPeer, valves: ModbusValves) -> None:
    peer.exception = 6
    assert valves.exchange(wanted(), 0.05) is None and valves.rejected == 1
    peer.exception = 2
    with pytest.raises(DeviceError, match="has no such register"):
        valves.exchange(wanted(), ANSWER_S)


def test_half_an_answer_is_none_and_what_follows_is_no_modbus(peer: ModbusPeer, valves: ModbusValves) -> None:
    peer.half_frame()
    with pytest.raises(DeviceError):
        for _ in range(6):
            valves.exchange(wanted(), 0.05)
    valves.open()
    assert valves.exchange(wanted(), ANSWER_S) is not None


def test_a_terminal_that_lost_its_power_is_started_again(peer: ModbusPeer, valves: ModbusValves, plant: Plant) -> None:
    valves.exchange(wanted(), ANSWER_S)
    peer.reset()
    assert plant.drive.vent
    with pytest.raises((DeviceError, OSError)):
        valves.exchange(wanted(), ANSWER_S)
    valves.open()
    assert plant.vented_within(0.0) == 0.0 or not plant.drive.pressures.any()
    reading = valves.exchange(wanted(), ANSWER_S)
    assert reading is not None and reading.stopped == "" and plant.drive.pressures[3] == SETPOINTS[3]


def test_an_unplugged_terminal_is_found_again(peer: ModbusPeer, valves: ModbusValves) -> None:
    valves.exchange(wanted(), ANSWER_S)
    peer.unplug()
    with pytest.raises((DeviceError, OSError)):
        valves.exchange(wanted(), ANSWER_S)
    valves.close()
    with pytest.raises(DeviceError):
        valves.open()
    peer.plug()
    valves.open()
    assert valves.exchange(wanted(), ANSWER_S) is not None


def test_close_ends_a_call_that_waits(peer: ModbusPeer, valves: ModbusValves) -> None:
    peer.freeze()
    errors: list[Exception] = []

    def wait() -> None:
        try:
            valves.exchange(wanted(), 5.0)
        except (DeviceError, OSError) as error:
            errors.append(error)

    thread = threading.Thread(target=wait)
    thread.start()
    time.sleep(0.1)
    valves.close()
    thread.join(60.0)
    assert not thread.is_alive() and len(errors) == 1


def test_a_map_of_registers_reads_and_writes_them(peer: ModbusPeer) -> None:
    options = {
        "map": "registers",
        "pressure_registers": [45396, 45397, 45399, 45400],
        "setpoint_registers": [40004, 40005, 40007, 40008],
        "setpoint_scale": 10.0,
        "pressure_zero": 500.0,
        "dump_register": -1,
    }
    valves = valves_at(peer, **options)
    reading = valves.exchange(wanted(np.array([100.0, 200.0, 300.0, -10.0])), ANSWER_S)
    valves.close()
    assert reading is not None and reading.pressures.tolist() == [500.0, 1500.0, 2500.0, 3500.0]
    written = peer.terminal.registers(time.monotonic())
    assert [written[register] for register in options["setpoint_registers"]] == [10, 20, 30, 65535]


@pytest.mark.parametrize(
    ("options", "chambers", "raw", "text"),
    [
        ({}, (0, 1, 2, 16), False, r"a VTEM has channels 0 to 15"),
        ({}, (0, 1, 2, 3), True, r"motion app 03 takes pressures"),
        (
            {"map": "registers", "pressure_registers": [1, 2, 3], "setpoint_registers": [5, 6, 7, 8]},
            (0, 1, 2, 3),
            False,
            r"the register lists name channels 0 to 2",
        ),
        (
            LISTED | {"signed": False},
            (0, 1, 2, 3),
            True,
            r"signed = false: a word without a sign cannot hold the -1000 counts at which a valve exhausts",
        ),
        ({"dump_register": 40003}, (0, 1, 2, 3), False, r"dump_register = 40003 is written for the valves, too"),
        ({"dump_register": 40007}, (0, 1, 2, 3), False, r"dump_register = 40007 is written for the valves, too"),
        ({"dump_register": 46100}, (0, 1, 2, 3), False, r"dump_register = 46100 is written for the valves, too"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_opened(
    options: dict[str, Any], chambers: tuple[int, ...], raw: bool, text: str
) -> None:
    with pytest.raises(ParameterError, match=text):
        ModbusValves(ModbusValves.Options(**options), chambers, raw)


@pytest.mark.parametrize("scale", [1.0, 1000.0, 32767.0])
def test_a_vented_map_of_raw_valves_exhausts_by_all_that_it_can(scale: float) -> None:
    options = ModbusValves.Options(**LISTED, opening_scale=scale)
    assert words_of(vented(), options, raw=True) == [[int(-scale) & 0xFFFF]] * 4


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"watchdog": 0.05}, "watchdog = 0.05 s is below 0.1 s"),
        ({"map": "registers"}, "needs pressure_registers and setpoint_registers"),
        ({"signed": False}, "millibar have a sign"),
        (
            {"map": "registers", "pressure_registers": [1], "setpoint_registers": [5, 5]},
            "names one twice",
        ),
        ({"dump_register": 40027, "dump_shut": 0}, "dump_shut = 0: 0 opens the dump valve"),
        (LISTED | {"setpoint_type": "int32"}, r"setpoint_registers = \[11, 12, 13, 14\] names one twice"),
        (LISTED | {"setpoint_registers": [65535], "setpoint_type": "float32"}, "ends at 65536"),
        (LISTED | {"pressure_registers": [65535], "pressure_type": "int32"}, "ends at 65536"),
        (
            LISTED | {"setpoint_registers": [11, 13, 15, 17], "setpoint_type": "int32", "write_single": True},
            "function 6 writes one register, int32 takes two",
        ),
        (LISTED | {"setpoint_zero": 100e3, "signed": False}, "setpoint_zero = 100000 Pa: the -1000 counts of a vent"),
        ({"pressure_type": "float32"}, "map = vtem has its own words"),
        ({"swapped_bytes": True}, "map = vtem has its own words"),
        ({"write_single": True}, "map = vtem takes no write_single"),
    ],
)
def test_options_that_do_not_fit_are_refused(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        ModbusValves.Options(**options)
