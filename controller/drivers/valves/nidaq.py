"""Valves and pressure sensors at National Instruments hardware: analogue out and in, a digital line for a dump valve.

Written by the documentation of nidaqmx, and never run on a device: none was there (docs/modbus.md).
"""

import time
from contextlib import suppress
from typing import Annotated, Any, Literal, Self

import numpy as np
from nidaqmx import Task
from nidaqmx.constants import Level, TerminalConfiguration, WatchdogAOExpirState
from nidaqmx.errors import DaqNotFoundError, DaqNotSupportedError
from nidaqmx.errors import Error as AnyDaqError
from nidaqmx.stream_readers import AnalogMultiChannelReader
from nidaqmx.stream_writers import AnalogMultiChannelWriter, DigitalSingleChannelWriter
from nidaqmx.system.watchdog import WatchdogTask
from nidaqmx.types import AOExpirationState, DOExpirationState
from pydantic import Field as Bounds
from pydantic import model_validator

from controller.arrays import Array
from controller.drivers.device import DeviceError, Outlet, Reading, ValveDevice
from controller.errors import ParameterError
from controller.schema.hardware import CHANNELS
from controller.schema.layout import Model

PhysicalChannel = Annotated[str, Bounds(pattern=r"^[A-Za-z0-9_-]{1,60}/[A-Za-z0-9_/-]{1,60}$")]
PhysicalChannels = Annotated[list[PhysicalChannel], Bounds(min_length=4, max_length=CHANNELS)]
Volts = Annotated[float, Bounds(ge=-10.0, le=10.0)]
TERMINALS = {
    "default": TerminalConfiguration.DEFAULT,
    "rse": TerminalConfiguration.RSE,
    "nrse": TerminalConfiguration.NRSE,
    "dif": TerminalConfiguration.DIFF,
    "pseudo_dif": TerminalConfiguration.PSEUDO_DIFF,
}


class NiDaqOptions(Model):
    """Which terminals, and what a volt means."""

    outputs: PhysicalChannels = Bounds(default=["Dev1/ao0", "Dev1/ao1", "Dev1/ao2", "Dev1/ao3"])
    """The valve of channel 0, 1, ..."""
    inputs: PhysicalChannels = Bounds(default=["Dev1/ai0", "Dev1/ai1", "Dev1/ai2", "Dev1/ai3"])
    """The pressure sensor of channel 0, 1, ..."""
    terminal: Literal["default", "rse", "nrse", "dif", "pseudo_dif"] = "default"
    """How the sensors are wired."""
    dump_line: Annotated[str, Bounds(pattern=r"^([A-Za-z0-9_-]{1,60}/[A-Za-z0-9_/-]{1,60})?$")] = ""
    """Digital line, as "Dev1/port0/line0", that holds an external dump valve shut while high; "": there is none."""
    heartbeat_line: Annotated[str, Bounds(pattern=r"^([A-Za-z0-9_-]{1,60}/[A-Za-z0-9_/-]{1,60})?$")] = ""
    """Digital line that changes with every exchange that does not vent, for a relay that watches it; "": none."""
    output_zero: Volts = 0.0
    """For a setpoint of 0 Pa, or a shut valve [V]."""
    output_scale: Annotated[float, Bounds(ge=100.0, le=1e6)] = 100e3
    """Of a volt of setpoint [Pa/V]."""
    opening_volts: Annotated[float, Bounds(gt=0.0, le=10.0)] = 5.0
    """From shut to wholly open, for `valves.command = "opening"` [V]."""
    output_min: Volts = 0.0
    """No voltage below this leaves [V]."""
    output_max: Volts = 10.0
    """No voltage above this leaves [V]."""
    input_zero: Volts = 0.0
    """Of a sensor at gauge pressure 0 [V]."""
    input_scale: Annotated[float, Bounds(ge=100.0, le=1e6)] = 100e3
    """Of a volt of a sensor [Pa/V]."""
    input_min: Volts = -10.0
    """Range of the inputs [V]."""
    input_max: Volts = 10.0
    """Range of the inputs [V]."""
    watchdog_device: Annotated[str, Bounds(pattern=r"^[A-Za-z0-9_-]{0,60}$")] = ""
    """Device whose watchdog timer brings outputs and dump line to rest, where it has one; "": none."""
    watchdog: Annotated[float, Bounds(ge=0.05, le=10.0)] = 0.2
    """That timer's [s]."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for low, high in (("output_min", "output_max"), ("input_min", "input_max")):
            if getattr(self, low) >= getattr(self, high):
                raise ValueError(f"{low} = {getattr(self, low):g} V is not below {high} = {getattr(self, high):g} V")
        if not self.output_min <= self.output_zero <= self.output_max:
            raise ValueError(f"output_zero = {self.output_zero:g} V is outside [output_min, output_max]")
        return self


class NiDaq(ValveDevice[NiDaqOptions]):
    """Outputs keep their voltage when a program dies: see `watchdog_device`, or drive the dump line by a relay."""

    Options = NiDaqOptions
    capabilities = ("setpoints", "raw openings", "supply cut by dump_line")
    clock = "arrival"
    period = 0.002

    def __init__(self, options: NiDaqOptions, chambers: tuple[int, ...], raw: bool) -> None:
        """Raises ParameterError where a chamber has no terminal, or no voltage within the limits empties it."""
        super().__init__(options, chambers, raw)
        known = min(len(options.outputs), len(options.inputs))
        if max(chambers) >= known:
            raise ParameterError(f"valves.chambers = {list(chambers)}: there are channels 0 to {known - 1}")
        exhausting = options.output_zero - options.opening_volts
        if raw and exhausting < options.output_min:
            raise ParameterError(f"output_min = {options.output_min:g} V: a valve exhausts at {exhausting:g} V")
        self._outputs = [options.outputs[channel] for channel in chambers]
        self._inputs = [options.inputs[channel] for channel in chambers]
        self._tasks: list[Any] = []
        self._writer: Any = None
        self._reader: Any = None
        self._dump: Any = None
        self._heartbeat: Any = None
        self._beat = False
        self._watchdog: Any = None
        self._volts = np.zeros(4)

    @property
    def name(self) -> str:
        """As "NI Dev1/ao0 to Dev1/ao3"."""
        return f"NI {self._outputs[0]} to {self._outputs[-1]}"

    def open(self) -> None:
        """Reserve the terminals and vent; DeviceError "needs hardware: ..." where there are none."""
        self.close()
        try:
            self._open_outputs()
            self._open_inputs()
            self._open_watchdog()
        except (DaqNotFoundError, DaqNotSupportedError) as error:
            self.close()
            raise DeviceError(f"needs hardware: no NI-DAQmx on this machine: {error}") from error
        except AnyDaqError as error:
            self.close()
            raise DeviceError(f"needs hardware: {self.name}: {_first_line(error)}") from error

    def _task(self, kind: type[Any], *about: Any, **more: Any) -> Any:
        task = kind(*about, **more)
        self._tasks.append(task)
        return task

    def _open_outputs(self) -> None:
        options = self.options
        self._dump = self._line(options.dump_line)
        self._heartbeat = self._line(options.heartbeat_line)
        out = self._task(Task)
        for name in self._outputs:
            out.ao_channels.add_ao_voltage_chan(name, min_val=options.output_min, max_val=options.output_max)
        self._writer = AnalogMultiChannelWriter(out.out_stream, auto_start=True)
        self._writer.write_one_sample(vented_volts(options, self.raw))

    def _line(self, name: str) -> Any:
        """Writer of a digital line, which is low now; None for ""."""
        if not name:
            return None
        line = self._task(Task)
        line.do_channels.add_do_chan(name)
        writer = DigitalSingleChannelWriter(line.out_stream, auto_start=True)
        writer.write_one_sample_one_line(False)
        return writer

    def _open_inputs(self) -> None:
        options = self.options
        into = self._task(Task)
        for name in self._inputs:
            into.ai_channels.add_ai_voltage_chan(
                name,
                terminal_config=TERMINALS[options.terminal],
                min_val=options.input_min,
                max_val=options.input_max,
            )
        self._reader = AnalogMultiChannelReader(into.in_stream)
        into.start()  # else each read would start and stop it

    def _open_watchdog(self) -> None:
        options = self.options
        if not options.watchdog_device:
            return
        self._watchdog = self._task(WatchdogTask, options.watchdog_device, timeout=options.watchdog)
        rest = vented_volts(options, self.raw)
        self._watchdog.cfg_watchdog_ao_expir_states(
            [
                AOExpirationState(name, float(volts), WatchdogAOExpirState.VOLTAGE)
                for name, volts in zip(self._outputs, rest, strict=True)
            ]
        )
        if options.dump_line:
            self._watchdog.cfg_watchdog_do_expir_states([DOExpirationState(options.dump_line, Level.LOW)])
        self._watchdog.start()

    def close(self) -> None:
        """Vent, because outputs keep their voltage, and give the terminals back."""
        with suppress(Exception):
            self._send(True, vented_volts(self.options, self.raw), 0.1)
        tasks, self._tasks = self._tasks, []
        self._writer = self._reader = self._dump = self._heartbeat = self._watchdog = None
        for task in tasks:
            with suppress(Exception):
                task.close()

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        """Set the voltages, then measure once: both without a clock of the device's own, as we ask."""
        try:
            self._send(outlet.vents(self.raw), volts_of(outlet, self.options, self.raw), timeout)
            asked = time.monotonic_ns()
            self._ready().read_one_sample(self._volts, timeout=timeout)
        except AnyDaqError as error:
            raise DeviceError(f"{self.name}: {_first_line(error)}") from error
        pressures = (self._volts - self.options.input_zero) * self.options.input_scale
        return Reading((asked + time.monotonic_ns()) // 2, pressures)

    def _ready(self) -> Any:
        if self._reader is None:
            raise DeviceError("not open")
        return self._reader

    def _send(self, vent: bool, volts: Array, timeout: float) -> None:
        if self._watchdog is not None:
            self._watchdog.reset_timer()
        if self._dump is not None:
            self._dump.write_one_sample_one_line(not vent, timeout=timeout)
        if self._heartbeat is not None and not vent:
            self._beat = not self._beat
            self._heartbeat.write_one_sample_one_line(self._beat, timeout=timeout)
        if self._writer is not None:
            self._writer.write_one_sample(volts, timeout=timeout)


def vented_volts(options: NiDaqOptions, raw: bool) -> Array:
    """(4,) that let the air out [V]."""
    low = options.output_zero - options.opening_volts if raw else options.output_zero
    return np.full(4, np.clip(low, options.output_min, options.output_max))


def volts_of(outlet: Outlet, options: NiDaqOptions, raw: bool) -> Array:
    """(4,) for what is wanted, within the outputs' limits [V]; what is not finite vents."""
    if outlet.vents(raw):
        return vented_volts(options, raw)
    wanted = outlet.wanted(raw)
    each = np.clip(wanted, -1.0, 1.0) * options.opening_volts if raw else wanted / options.output_scale
    return np.clip(options.output_zero + each, options.output_min, options.output_max)


def _first_line(error: Exception) -> str:
    return str(error).strip().split("\n", 1)[0]
