"""What a rig file may say of valves behind Modbus TCP."""

from typing import Annotated, Literal, Self

from pydantic import Field as Bounds
from pydantic import model_validator

from controller.drivers.valves.modbus.words import Coding, Kind
from controller.schema.hardware import CHANNELS
from controller.schema.layout import Model

REGISTER_MAX = 65535
PLAIN = Coding("int16", True, low_word_first=False, swapped_bytes=False)
"""Of a VTEM."""
Register = Annotated[int, Bounds(ge=0, le=REGISTER_MAX)]
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
    pressure_type: Kind = "int16"
    """registers: what a pressure is; of two registers the list names the first."""
    setpoint_type: Kind = "int16"
    """registers: what a setpoint, or opening, is."""
    signed: bool = True
    """registers: integers are two's complement, as openings need where a valve exhausts at negative counts."""
    low_word_first: bool = False
    """registers: the first of two registers holds the low half."""
    swapped_bytes: bool = False
    """registers: each holds its low byte first."""
    write_single: bool = False
    """registers: each is written by a request of its own (function 6), for a device that knows no other."""
    pressure_scale: Annotated[float, Bounds(ge=1e-3, le=1e6)] = 100.0
    """Of a count of pressure [Pa]; 100: millibar, and 1e5 where a float is in bar."""
    pressure_zero: Annotated[float, Bounds(ge=-1e6, le=1e6)] = 0.0
    """Gauge pressure of count 0 [Pa]."""
    setpoint_scale: Annotated[float, Bounds(ge=1e-3, le=1e6)] = 100.0
    """Of a count of setpoint [Pa]."""
    setpoint_zero: Annotated[float, Bounds(ge=-1e6, le=1e6)] = 0.0
    """Gauge pressure that a setpoint of count 0 asks for [Pa]."""
    setpoint_min: Annotated[float, Bounds(ge=-100e3, le=0.0)] = -90e3
    """No setpoint below this leaves [Pa]."""
    setpoint_max: Annotated[float, Bounds(gt=0.0, le=1e6)] = 700e3
    """No setpoint above this leaves [Pa]."""
    opening_scale: Annotated[float, Bounds(ge=1.0, le=32767.0)] = 1000.0
    """Counts of a valve that is wholly open, for `valves.command = "opening"`."""
    opening_zero: Annotated[float, Bounds(ge=-32768.0, le=65535.0)] = 0.0
    """Counts of a valve that is shut, to which those are added."""

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
        if self.dump_register >= 0 and self.dump_shut == 0:
            raise ValueError("dump_shut = 0: 0 opens the dump valve, so something else must hold it shut")
        if self.map == "vtem" and not self.signed:
            raise ValueError("signed = false: a VTEM's millibar have a sign")
        self._listed_fit()
        return self

    def _listed_fit(self) -> None:
        """Raise ValueError where listed registers overlap, end beyond the last, or cannot hold or take a vent."""
        coding = self.setpoints
        listed = self.setpoint_registers
        written = [register + i for register in listed for i in range(coding.width)]
        if len(set(written)) != len(written) or self.dump_register in written:
            raise ValueError(f"setpoint_registers = {listed} names one twice, or the dump_register")
        last = max(
            [*written, *(register + self.pressures.width - 1 for register in self.pressure_registers)], default=0
        )
        if last > REGISTER_MAX:
            raise ValueError(f"a number of two registers ends at {last}, above the last register, {REGISTER_MAX}")
        if self.map == "vtem" and {coding, self.pressures} != {PLAIN}:
            raise ValueError("map = vtem has its own words: leave out pressure_type, setpoint_type and their order")
        if self.map == "vtem" and (self.write_single or self.setpoint_zero != 0.0):
            raise ValueError("map = vtem takes no write_single and no setpoint_zero: its setpoints are mbar")
        if self.write_single and coding.width > 1:
            raise ValueError(f"write_single = true: function 6 writes one register, {self.setpoint_type} takes two")
        vented = -self.setpoint_zero / self.setpoint_scale
        if not coding.range[0] <= vented <= coding.range[1]:
            raise ValueError(f"setpoint_zero = {self.setpoint_zero:g} Pa: the {vented:g} counts of a vent do not fit")

    @property
    def pressures(self) -> Coding:
        """How a pressure lies in its registers."""
        return Coding(self.pressure_type, self.signed, self.low_word_first, self.swapped_bytes)

    @property
    def setpoints(self) -> Coding:
        """How a setpoint, or opening, does."""
        return Coding(self.setpoint_type, self.signed, self.low_word_first, self.swapped_bytes)
