"""What a rig file may say of valves behind Modbus TCP."""

from typing import Annotated, Literal, Self

from pydantic import Field as Bounds
from pydantic import model_validator

from controller.schema.hardware import CHANNELS
from controller.schema.layout import Model

Register = Annotated[int, Bounds(ge=0, le=65535)]
"""As it stands in the request: a manual that counts from 1 names the next number."""
MaybeRegister = Annotated[int, Bounds(ge=-1, le=65535)]
"""-1: there is none."""
Word = Annotated[int, Bounds(ge=0, le=65535)]
Registers = Annotated[list[Register], Bounds(max_length=CHANNELS)]


class ModbusOptions(Model):
    """Where the device is, and which register is what."""

    host: Annotated[str, Bounds(min_length=1, max_length=253)] = "192.168.1.1"
    port: Annotated[int, Bounds(ge=1, le=65535)] = 502
    unit: Annotated[int, Bounds(ge=0, le=255)] = 1
    """Unit identifier; answers of another are rejected."""
    map: Literal["vtem", "registers"] = "vtem"
    """Festo VTEM in a CPX terminal, or the registers listed below."""

    input_base: Register = 45392
    """vtem: first input register of the CPX terminal."""
    output_base: Register = 40001
    """vtem: its first output register."""
    input_offset: Annotated[int, Bounds(ge=0, le=1000)] = 3
    """vtem: input registers of the modules before the VTEM."""
    output_offset: Annotated[int, Bounds(ge=0, le=1000)] = 2
    """vtem: output registers of the modules before it."""
    start_time: Annotated[float, Bounds(ge=0.1, le=60.0)] = 20.0
    """vtem: longest wait until the motion app runs in every slot [s]."""
    fail_safe: Literal["check", "set", "ignore"] = "check"
    """vtem: refuse a terminal that holds its outputs when its host dies, set it to reset them, or do not ask."""

    pressure_registers: Registers = Bounds(default=[])
    """registers: the pressure of channel 0, 1, ..."""
    setpoint_registers: Registers = Bounds(default=[])
    """registers: the setpoint, or opening, of channel 0, 1, ..."""
    input_registers: bool = False
    """registers: pressures are read as input registers (function 4), else as holding registers."""
    read_gap: Annotated[int, Bounds(ge=0, le=100)] = 8
    """Registers that no one asked for and that are read along, if one request is saved by it."""
    signed: bool = True
    """registers: words are two's complement, as openings need, which are negative where a valve exhausts."""
    pressure_scale: Annotated[float, Bounds(ge=1e-3, le=1e5)] = 100.0
    """Of a count of pressure [Pa]; 100: millibar."""
    pressure_zero: Annotated[float, Bounds(ge=-1e6, le=1e6)] = 0.0
    """Gauge pressure of count 0 [Pa]."""
    setpoint_scale: Annotated[float, Bounds(ge=1e-3, le=1e5)] = 100.0
    """Of a count of setpoint [Pa]."""
    setpoint_min: Annotated[float, Bounds(ge=-100e3, le=0.0)] = -90e3
    """No setpoint below this leaves [Pa]."""
    setpoint_max: Annotated[float, Bounds(gt=0.0, le=1e6)] = 700e3
    """No setpoint above this leaves [Pa]."""
    opening_scale: Annotated[float, Bounds(ge=1.0, le=32767.0)] = 1000.0
    """Counts of a valve that is wholly open, for `valves.command = "opening"`."""

    combined: bool = True
    """Write and read in one request (function 23), where the device knows it."""
    connect_time: Annotated[float, Bounds(ge=0.05, le=10.0)] = 1.0
    """Longest wait for a connection, and for an answer while it is set up [s]."""
    watchdog: Annotated[float, Bounds(ge=0.0, le=60.0)] = 0.5
    """The device resets its outputs after so long without a request [s], 0.1 at least; 0: it is not told to."""
    watchdog_register: MaybeRegister = -1
    """Takes that time in milliseconds; -1: 46100 of a CPX terminal for vtem, none for registers."""
    dump_register: MaybeRegister = -1
    """Of an output that holds an external dump valve shut."""
    dump_shut: Word = 1
    """Written there while pressures are wanted, not 0; 0 while vented, and by the device when its watchdog bites."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if 0.0 < self.watchdog < 0.1:
            raise ValueError(f"watchdog = {self.watchdog:g} s is below 0.1 s, the least that a CPX terminal takes")
        if self.map == "registers" and not (self.pressure_registers and self.setpoint_registers):
            raise ValueError("map = registers needs pressure_registers and setpoint_registers")
        written = self.setpoint_registers
        if len(set(written)) != len(written) or self.dump_register in written:
            raise ValueError(f"setpoint_registers = {written} names one twice, or the dump_register")
        if self.dump_register >= 0 and self.dump_shut == 0:
            raise ValueError("dump_shut = 0: 0 opens the dump valve, so something else must hold it shut")
        if self.map == "vtem" and not self.signed:
            raise ValueError("signed = false: a VTEM's millibar have a sign")
        return self
