"""Registers of other devices than a VTEM, at the virtual terminal's: what is a number there, and how it is written."""

import struct
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from controller.drivers.valves.modbus.driver import ModbusValves
from controller.drivers.valves.modbus.registers import words_of
from controller.virtual.modbus_server import ModbusPeer
from tests.controller.drivers.commands import ANSWER_S, Plant, vented, wanted
from tests.controller.drivers.valves.test_modbus import LISTED, valves_at

PORTS = [40004, 40007, 40010, 40013]
"""Of a device whose setpoints are two registers each, among those of a VTEM."""
SHOWN = [45396, 45399, 45402, 45405]
"""Its pressures: two registers each, in which the VTEM has the millibar of two channels."""


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({}, lambda high, low: high << 16 | low),
        ({"low_word_first": True}, lambda high, low: low << 16 | high),
        ({"swapped_bytes": True}, lambda high, low: int.from_bytes(struct.pack("<HH", high, low), "big")),
    ],
)
def test_numbers_of_two_registers_are_read_in_the_devices_order(
    peer: ModbusPeer, plant: Plant, options: dict[str, Any], word: Callable[[int, int], int]
) -> None:
    asked = {"map": "registers", "pressure_registers": SHOWN, "setpoint_registers": PORTS, "dump_register": -1}
    valves = valves_at(peer, **asked, pressure_type="int32", signed=False, pressure_scale=0.001, **options)
    reading = valves.exchange(vented(), ANSWER_S)
    valves.close()
    millibar = np.rint(plant.read()[:8] / 100.0).astype(int).reshape(4, 2)
    assert len(set(millibar.ravel())) == 8
    assert reading is not None
    assert reading.pressures == pytest.approx([0.001 * word(int(a), int(b)) for a, b in millibar])


@pytest.mark.parametrize(("order", "code"), [({}, ">f"), ({"low_word_first": True, "swapped_bytes": True}, "<f")])
def test_floats_in_bar_are_written_in_the_devices_order(peer: ModbusPeer, order: dict[str, Any], code: str) -> None:
    asked = {"map": "registers", "pressure_registers": SHOWN, "setpoint_registers": PORTS, "dump_register": -1}
    valves = valves_at(peer, **asked, setpoint_type="float32", setpoint_scale=1e5, **order)
    assert valves.exchange(wanted(np.array([10e3, 20e3, 30e3, -5e3])), ANSWER_S) is not None
    valves.close()
    written = peer.terminal.registers(time.monotonic())
    words = [struct.pack(">HH", written[register], written[register + 1]) for register in PORTS]
    assert [struct.unpack(code, word)[0] for word in words] == pytest.approx([0.1, 0.2, 0.3, -0.05])


def test_a_loop_of_4_to_20_ma_has_its_zero_where_nothing_is_asked_for(peer: ModbusPeer) -> None:
    """4000 counts are 0 Pa and 20000 are 400 kPa: 25 Pa of a count."""
    asked = {"map": "registers", "pressure_registers": SHOWN, "setpoint_registers": PORTS, "dump_register": -1}
    scale = {"setpoint_scale": 25.0, "setpoint_zero": -100e3, "pressure_scale": 25.0, "pressure_zero": -100e3}
    valves = valves_at(peer, **asked, **scale)
    words = []
    for outlet in (wanted(np.array([0.0, 100e3, 200e3, 400e3])), vented()):
        reading = valves.exchange(outlet, ANSWER_S)
        written = peer.terminal.registers(time.monotonic())
        words.append([written[register] for register in PORTS])
    valves.close()
    assert words == [[4000, 8000, 12000, 20000], [4000] * 4]
    assert reading is not None and (reading.pressures < -90e3).all(), "a broken wire is far below the atmosphere"


def test_a_device_that_knows_function_06_only_is_written_word_by_word(peer: ModbusPeer) -> None:
    peer.unknown = {16, 23}
    asked = {"map": "registers", "pressure_registers": SHOWN, "setpoint_registers": [40004, 40005, 40007, 40008]}
    valves = valves_at(peer, **asked, write_single=True)
    reading = valves.exchange(wanted(np.array([1000.0, 2000.0, 3000.0, 4000.0])), ANSWER_S)
    valves.close()
    written = peer.terminal.registers(time.monotonic())
    assert reading is not None
    assert [written[register] for register in asked["setpoint_registers"]] == [10, 20, 30, 40]
    assert written[int(peer.options["dump_register"])] == 1


def test_openings_around_a_shut_valve_exhaust_at_the_least_count() -> None:
    middle = {"signed": False, "opening_zero": 12000.0, "opening_scale": 8000.0}
    valves = ModbusValves(ModbusValves.Options(**LISTED, **middle), (0, 1, 2, 3), True)
    openings = wanted(np.zeros(4))._replace(openings=np.array([-1.0, 0.0, 0.5, 1.0]))
    assert words_of(openings, valves.options, raw=True) == [[4000], [12000], [16000], [20000]]
    assert words_of(vented(), valves.options, raw=True) == [[4000]] * 4
