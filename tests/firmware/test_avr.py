"""The sketches for AVR: they are built with Arduino's own core, fit, and the Uno's runs on a simulated chip."""

import shutil
import subprocess
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from controller.drivers.valves.serial_board import frames
from controller.drivers.valves.serial_board.frames import Cutter, HelloReply, State
from controller.virtual.firmware import firmware_folder
from tests.firmware import simulated_avr
from tests.firmware.simulated_avr import SimulatedAvr

ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h")
MISSING = [name for name in ("avr-g++", "avr-size", "make") if shutil.which(name) is None]
pytestmark = [
    pytest.mark.keyed("firmware"),
    pytest.mark.skipif(
        bool(MISSING) or not ARDUINO.exists(),
        reason=f"needs {', '.join(MISSING) or 'arduino-core-avr'}. On Debian: apt-get install gcc-avr arduino-core-avr",
    ),
]
RAM = {"uno": 2048, "mega": 8192}
FLASH = {"uno": 32256, "mega": 253952}
"""Without the boot loader."""
MILLISECOND = 12_000
"""About so many instructions."""
ATMOSPHERE = 0.498
"""What the sensors of the sketch say at 0 Pa gauge [V]."""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("avr")
    done = subprocess.run(["make", "-C", firmware_folder(), "avr", f"BUILD={folder}"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("board", ["uno", "mega"])
def test_the_sketch_leaves_half_of_the_memory_free(built: Path, board: str) -> None:
    words = subprocess.run(["avr-size", built / f"{board}.elf"], capture_output=True, text=True).stdout.split()
    text, data, bss = map(int, words[6:9])
    print(f"{board}: {text + data} bytes of flash, {data + bss} of RAM")
    assert text + data < FLASH[board] / 2
    assert data + bss < RAM[board] / 2


class Uno:
    """The Uno's sketch, and the host's side of its line."""

    def __init__(self, built: Path) -> None:
        self.chip = SimulatedAvr("atmega328p", built / "uno.elf")
        self._cutter = Cutter()
        self._sequence = 0
        for pin in ("D2", "D3", "B2"):
            self.chip.watch(pin)
        self.chip.set_pin("B3", 0)
        for channel in range(4):
            self.chip.set_voltage(channel, ATMOSPHERE)
        self.chip.run(20 * MILLISECOND)

    def ask(self, wire: bytes, patience: int = 100) -> HelloReply | State | None:
        self.chip.hear(wire)
        for _ in range(patience):
            self.chip.run(MILLISECOND // 10)
            found = self._cutter.feed(bytes(self.chip.said))
            self.chip.said.clear()
            if found:
                return found[0]
        return None

    def hello(self) -> HelloReply:
        self._sequence += 1
        found = self.ask(frames.hello(self._sequence, 42))
        assert isinstance(found, HelloReply)
        return found

    def command(self, wanted: int, *targets: int) -> State:
        self._sequence += 1
        driven = 0 if wanted & frames.VENT else 0b1111
        found = self.ask(frames.command(self._sequence, 42, wanted, driven, targets or (0, 0, 0, 0)))
        assert isinstance(found, State)
        return found


@pytest.fixture
def uno(built: Path) -> Iterator[Uno]:
    if not simulated_avr.there():
        pytest.skip("needs libsimavr. On Debian: apt-get install simavr")
    made = Uno(built)
    yield made
    made.chip.close()


def test_the_uno_answers_a_hello(uno: Uno) -> None:
    found = uno.hello()
    assert (found.name, found.channels, found.host_us, found.pressure_max) == ("Arduino Uno", 4, 42, 300_000)


def test_the_uno_drives_its_valves_after_a_vent_only(uno: Uno) -> None:
    uno.hello()
    assert uno.command(frames.RAW, 32767, 0, 0, 0).stopped == frames.BOOT | frames.GREETED
    assert (uno.chip.pins.get("D2", 0), uno.chip.pins.get("D3", 0)) == (0, 0)  # no current: shut, and open
    assert uno.command(frames.RAW | frames.VENT).stopped == 0
    uno.command(frames.RAW, 32767, 0, 0, 0)
    uno.chip.run(3 * MILLISECOND)
    assert (uno.chip.pins["D2"], uno.chip.pins["D3"], uno.chip.pins["B2"]) == (1, 1, 1)


def test_the_uno_reads_pressures(uno: Uno) -> None:
    uno.hello()
    uno.chip.set_voltage(0, 0.5 + 4.0 * 200 / 500)
    uno.chip.set_voltage(2, 0.0)
    uno.chip.run(3 * MILLISECOND)
    found = uno.command(frames.VENT)
    assert found.pressures[0] == pytest.approx(200e3, abs=1e3)
    assert found.pressures[1] == pytest.approx(0.0, abs=1e3)
    assert found.pressures[2] == frames.BROKEN


def test_the_uno_vents_by_itself_when_nobody_speaks(uno: Uno) -> None:
    uno.hello()
    uno.command(frames.RAW | frames.VENT)
    before = uno.command(frames.RAW, 32767, 0, 0, 0)
    uno.chip.run(3 * MILLISECOND)
    assert uno.chip.pins["D2"] == 1
    uno.chip.run(130 * MILLISECOND)
    assert (uno.chip.pins["D2"], uno.chip.pins["D3"]) == (0, 0)
    after = uno.command(frames.RAW, 32767, 0, 0, 0)
    assert after.stopped == frames.WATCHDOG
    assert after.boot == before.boot


def test_the_uno_has_time_for_500_exchanges_a_second(uno: Uno) -> None:
    uno.hello()
    uno.command(frames.VENT)
    found = [uno.command(0, 1000, 1000, 1000, 1000) for _ in range(100)]
    apart = sorted(b.received_us - a.received_us for a, b in pairwise(found))
    old = max(one.received_us - one.read_us for one in found)
    print(f"an exchange on the Uno: {apart[50]} us, at most {apart[-1]}; pressures at most {old} us old")
    assert apart[50] < 1700  # of 2000; 780 of them are the line's
    assert old < 3000
    assert (found[-1].rejected, found[-1].stopped) == (0, 0)
