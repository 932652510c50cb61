"""Valves behind Modbus TCP as a device."""

import time

from controller.drivers.device import Outlet, Reading, ValveDevice
from controller.drivers.valves.modbus import vtem
from controller.drivers.valves.modbus.options import ModbusOptions
from controller.drivers.valves.modbus.registers import pressures_of, register_map, spans, values_of, words_of
from controller.drivers.valves.modbus.wire import ILLEGAL_FUNCTION, Refused, Wire
from controller.errors import ParameterError


class ModbusValves(ValveDevice[ModbusOptions]):
    """Registers in, registers out. It cannot cut the supply by itself: `dump_register` or a valve outside must."""

    Options = ModbusOptions
    capabilities = ("setpoints", "raw openings by a map", "watchdog of the device")
    clock = "arrival"
    period = 0.005

    def __init__(self, options: ModbusOptions, chambers: tuple[int, ...], raw: bool) -> None:
        """Raises ParameterError where the map has no such channels, or with it a vent would not let the air out."""
        super().__init__(options, chambers, raw)
        if raw:
            require_openings(options)
        self._map = register_map(options, chambers)
        self._wire = Wire(options.host, options.port, options.unit, options.write_single)
        self._commands = {slot.command: vtem.PRESSURE_APP | vtem.BOTH for slot in self._map.slots}
        setpoints = {(first, options.setpoints.width) for first in self._map.setpoints}
        written = setpoints | {(register, 1) for register in (*self._map.idle, *self._commands)}
        dump = {(options.dump_register, 1)} if options.dump_register >= 0 else set()
        if dump & (written | {(self._watchdog_register, 1)}):
            raise ParameterError(f"dump_register = {options.dump_register} is written for the valves, too")
        self._writes = spans(written | dump)
        status = {(slot.status, 1) for slot in self._map.slots}
        read = {(first, options.pressures.width) for first in self._map.pressures}
        self._reads = spans(read | status, options.read_gap)
        self._combined = options.combined and not options.input_registers and not options.write_single
        self._stopped = ""
        """Why it stopped driving by itself: it drives again only after it was told to vent."""

    @property
    def name(self) -> str:
        """As "Festo VTEM at 192.168.1.1:502"."""
        kind = "Festo VTEM" if self.options.map == "vtem" else "Modbus"
        return f"{kind} at {self.options.host}:{self.options.port}"

    @property
    def rejected(self) -> int:  # type: ignore[override]
        """Frames that were none, or not the answer to what was asked."""
        return self._wire.rejected

    @property
    def _watchdog_register(self) -> int:
        known = self.options.watchdog_register
        return vtem.WATCHDOG if known < 0 and self.options.map == "vtem" else known

    def open(self) -> None:
        """Connect, set the device's watchdog, and have a VTEM's motion app run at pressure 0."""
        self._wire.connect(self.options.connect_time)
        self._stopped = ""
        try:
            self._set_up(self.options.connect_time)
        except BaseException:
            self.close()
            raise

    def _set_up(self, timeout: float) -> None:
        options, wire = self.options, self._wire
        if options.watchdog > 0.0 and self._watchdog_register >= 0:
            vtem.set_watchdog(wire, self._watchdog_register, options.watchdog, timeout)
        if options.map != "vtem":
            return
        if options.fail_safe != "ignore":
            vtem.require_fail_safe(wire, options.output_base, options.input_base, options.fail_safe == "set", timeout)
        vtem.start(wire, self._map.slots, options.start_time, timeout)

    def close(self) -> None:
        """Drop the connection, and what it has not sent yet."""
        self._wire.close()

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        """Write all registers and read all; DeviceError after some silence or an exception."""
        asked = time.monotonic_ns()
        until = time.monotonic() + timeout
        image = self._image(outlet._replace(vent=True) if self._stopped else outlet)
        try:
            words = self._transact(image, until)
        except Refused as error:
            if error.code != ILLEGAL_FUNCTION or not self._combined:
                raise
            self._combined = False  # a device without function 23
            words = self._transact(image, until)
        if words is None:
            return None
        pressures = pressures_of(words, self._map.pressures, self.options)
        self._follow(words, outlet.vent or outlet.cut)
        return Reading(
            t_ns=(asked + time.monotonic_ns()) // 2,  # the device read them on the way
            pressures=pressures,
            stopped=self._stopped,
        )

    def _image(self, outlet: Outlet) -> dict[int, int]:
        """Each register that is written, and what."""
        image = dict.fromkeys(self._map.idle, 0) | dict(self._commands)
        for first, words in zip(self._map.setpoints, words_of(outlet, self.options, self.raw), strict=True):
            image |= dict(enumerate(words, first))
        if self.options.dump_register >= 0:
            image[self.options.dump_register] = 0 if outlet.vents(self.raw) else self.options.dump_shut
        return image

    def _follow(self, words: dict[int, int], vented: bool) -> None:
        complaint = vtem.complaint(self._map.slots, words)
        if complaint or vented:
            self._stopped = complaint
        for slot in self._map.slots:
            self._commands[slot.command] = vtem.command_of(vtem.status_of(words[slot.status]), vented)

    def _transact(self, image: dict[int, int], until: float) -> dict[int, int] | None:
        """All writes, then all reads, in as few requests as there may be; None if an answer is missing."""
        writes, reads = list(self._writes), list(self._reads)
        found: dict[int, int] = {}
        joined = (writes.pop(), reads.pop(0)) if self._combined else None
        for span in writes:
            if not self._wire.write(span[0], values_of(span, image), _left(until)):
                return None
        if joined is not None:
            write, read = joined
            words = self._wire.write_read((write[0], values_of(write, image)), read, _left(until))
            if words is None:
                return None
            found |= dict(enumerate(words, read[0]))
        for read in reads:
            words = self._wire.read(*read, _left(until), self.options.input_registers)
            if words is None:
                return None
            found |= dict(enumerate(words, read[0]))
        return found


def require_openings(options: ModbusOptions) -> None:
    """Raise ParameterError unless the device takes openings of both signs: the negative ones let the air out."""
    if options.map == "vtem":
        raise ParameterError("valves.command = opening: a VTEM's motion app 03 takes pressures")
    exhausts, least = options.opening_zero - options.opening_scale, options.setpoints.range[0]
    if exhausts < least:
        sign = (
            "signed = false: a word without a sign"
            if not options.signed
            else f"setpoint_type = {options.setpoint_type}"
        )
        raise ParameterError(
            f"{sign} cannot hold the {exhausts:g} counts at which a valve exhausts (valves.command = opening)"
        )


def _left(until: float) -> float:
    return max(0.0, until - time.monotonic())
