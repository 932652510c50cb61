"""An AVR chip by simavr: what its serial port says, and what its pins do. One instruction a call."""

import ctypes
from collections.abc import Callable
from pathlib import Path

LIBRARY = "libsimavr.so.2"
FIRMWARE_BYTES = 1 << 16
"""More than simavr's description of a program takes; name, clock and supply lie at its head."""
MILLIVOLTS = (5000, 5000, 5000)
IN, OUT = 0, 1
"""Of a serial port's lines."""

Notify = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_void_p)


def there() -> bool:
    """Whether simavr is installed."""
    try:
        ctypes.CDLL(LIBRARY)
    except OSError:
        return False
    return True


class SimulatedAvr:
    """A chip with a program in its flash."""

    def __init__(self, chip: str, program: Path, hertz: int = 16_000_000) -> None:
        lib = ctypes.CDLL(LIBRARY)
        for name in ("avr_make_mcu_by_name", "avr_io_getirq"):
            getattr(lib, name).restype = ctypes.c_void_p
        described = ctypes.create_string_buffer(FIRMWARE_BYTES)
        assert lib.elf_read_firmware(str(program).encode(), described) == 0
        ctypes.memmove(described, chip.encode().ljust(64, b"\0"), 64)
        ctypes.memmove(ctypes.addressof(described) + 64, (ctypes.c_uint32 * 4)(hertz, *MILLIVOLTS), 16)
        self._lib, self._chip = lib, ctypes.c_void_p(lib.avr_make_mcu_by_name(chip.encode()))
        assert lib.avr_init(self._chip) == 0
        lib.avr_load_firmware(self._chip, described)
        quiet = ctypes.c_uint32(0)
        lib.avr_ioctl(self._chip, control("uas0"), ctypes.byref(quiet))
        self.said = bytearray()
        """What the serial port sent and no one took."""
        self.pins: dict[str, int] = {}
        """Newest level of the pins that are watched, as "D3"."""
        self._kept: list[object] = []
        self._watch("uar0", OUT, lambda value: self.said.append(value & 0xFF))

    def close(self) -> None:
        """Let go of the chip."""
        self._lib.avr_terminate(self._chip)

    def run(self, instructions: int) -> None:
        """About 12 000 make a millisecond."""
        step, chip = self._lib.avr_run, self._chip
        for _ in range(instructions):
            step(chip)

    def hear(self, data: bytes) -> None:
        """Bytes arrive at the serial port, at its own rate; at most 60."""
        line = self._line("uar0", IN)
        for byte in data:
            self._lib.avr_raise_irq(line, ctypes.c_uint32(byte))

    def set_pin(self, name: str, level: int) -> None:
        """From outside, as "B3", stronger than any pull-up of the chip's."""
        bit = 1 << int(name[1])
        held = ctypes.c_ulong(ord(name[0]) | bit << 7 | (bit if level else 0) << 15)
        self._lib.avr_ioctl(self._chip, control(f"iop{name[0]}"), ctypes.byref(held))

    def set_voltage(self, channel: int, volts: float) -> None:
        """At an analog input."""
        self._lib.avr_raise_irq(self._line("adc ", channel), ctypes.c_uint32(round(volts * 1000)))

    def watch(self, name: str) -> None:
        """Keep `pins[name]`."""
        self._watch(f"iog{name[0]}", int(name[1]), lambda value: self.pins.__setitem__(name, value))

    def _watch(self, device: str, number: int, take: Callable[[int], None]) -> None:
        callback = Notify(lambda line, value, given: take(value))
        self._kept.append(callback)
        self._lib.avr_irq_register_notify(self._line(device, number), callback, None)

    def _line(self, device: str, number: int) -> ctypes.c_void_p:
        line = self._lib.avr_io_getirq(self._chip, control(device), number)
        assert line, f"the chip has no {device}"
        return ctypes.c_void_p(line)


def control(name: str) -> ctypes.c_uint32:
    """simavr's number of a device, of four letters."""
    return ctypes.c_uint32(int.from_bytes(name.encode(), "big"))
