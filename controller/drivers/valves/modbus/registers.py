"""Which register is what, and with how few requests all of them are written and read."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.drivers.device import Outlet
from controller.drivers.valves.modbus.options import ModbusOptions
from controller.errors import ParameterError

Span = tuple[int, int]
"""First register and count."""
REGISTERS_MAX = 120
"""Registers of a request that every function allows."""
SLOTS = 8
"""Valves of a VTEM: two channels each."""
SLOT_WORDS = 3
"""Registers of a slot, in and out: status or command, and one for each of the two channels."""


class Slot(NamedTuple):
    """A valve of a VTEM: where its command goes and its status comes from."""

    number: int
    command: int
    status: int


class RegisterMap(NamedTuple):
    """For the four chambers u1+, u1-, u2+, u2-."""

    pressures: tuple[int, ...]
    setpoints: tuple[int, ...]
    slots: tuple[Slot, ...]
    """Those of the chambers, if the valves are a VTEM's."""
    idle: tuple[int, ...]
    """Setpoints of a slot's other channel, which is kept at 0."""


def register_map(options: ModbusOptions, chambers: tuple[int, ...]) -> RegisterMap:
    """Of the channels `chambers`; ParameterError where there are no such."""
    if options.map == "vtem":
        return _vtem_map(options, chambers)
    known = min(len(options.pressure_registers), len(options.setpoint_registers))
    if max(chambers) >= known:
        raise ParameterError(f"valves.chambers = {list(chambers)}: the register lists name channels 0 to {known - 1}")
    pressures = tuple(options.pressure_registers[channel] for channel in chambers)
    return RegisterMap(pressures, tuple(options.setpoint_registers[channel] for channel in chambers), (), ())


def _vtem_map(options: ModbusOptions, chambers: tuple[int, ...]) -> RegisterMap:
    if max(chambers) >= 2 * SLOTS:
        raise ParameterError(f"valves.chambers = {list(chambers)}: a VTEM has channels 0 to {2 * SLOTS - 1}")
    into, out = options.input_base + options.input_offset, options.output_base + options.output_offset
    numbers = sorted({channel // 2 for channel in chambers})
    setpoints = tuple(out + SLOT_WORDS * (channel // 2) + 1 + channel % 2 for channel in chambers)
    both = {out + SLOT_WORDS * number + 1 + half for number in numbers for half in (0, 1)}
    return RegisterMap(
        pressures=tuple(into + SLOT_WORDS * (channel // 2) + 1 + channel % 2 for channel in chambers),
        setpoints=setpoints,
        slots=tuple(Slot(n, out + SLOT_WORDS * n, into + SLOT_WORDS * n) for n in numbers),
        idle=tuple(sorted(both - set(setpoints))),
    )


def spans(numbers: Iterable[Span], gap: int = 0) -> list[Span]:
    """Runs of registers that hold `numbers`, over gaps of up to `gap` registers, none longer than a request allows.

    No number is parted: its two halves would be those of two moments.
    """
    found: list[Span] = []
    for start, count in sorted(set(numbers)):
        if found and start - sum(found[-1]) <= gap and start + count - found[-1][0] <= REGISTERS_MAX:
            found[-1] = (found[-1][0], max(found[-1][1], start + count - found[-1][0]))
        else:
            found.append((start, count))
    return found


def words_of(outlet: Outlet, options: ModbusOptions, raw: bool) -> list[list[int]]:
    """What the registers of the four setpoints take: within the device's limits."""
    wanted, vent = outlet.wanted(raw), outlet.vents(raw)
    if raw:
        openings = np.full(4, -1.0) if vent else np.clip(wanted, -1.0, 1.0)
        counts = options.opening_zero + openings * options.opening_scale
    else:
        held = np.zeros(4) if vent else np.clip(wanted, options.setpoint_min, options.setpoint_max)
        counts = (held - options.setpoint_zero) / options.setpoint_scale
    return [options.setpoints.words(float(count)) for count in counts]


def pressures_of(words: Mapping[int, int], registers: Iterable[int], options: ModbusOptions) -> Array:
    """Gauge pressures (4,) [Pa] of the numbers that begin at `registers`, of which `words` has each; nan as it came."""
    width = options.pressures.width
    counts = [options.pressures.value([words[first + i] for i in range(width)]) for first in registers]
    return np.array(counts) * options.pressure_scale + options.pressure_zero


def values_of(span: Span, image: Mapping[int, int]) -> list[int]:
    """What is written to `span`."""
    return [image[register] for register in range(span[0], sum(span))]
