"""A board of the firmware with four chambers at its first channels."""

import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from controller.arrays import Array
from controller.drivers.device import Outlet, Reading
from controller.drivers.valves.serial_board.driver import SerialBoard, SerialOptions
from controller.virtual.board import BoardPeer
from controller.virtual.peers import Drive
from tests.firmware.far_end import Answers, FarEnd

Found = Callable[[], bool]


def wait_for(found: Found, timeout: float = 5.0) -> bool:
    """Whether `found` came true within `timeout` [s]."""
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        if found():
            return True
        time.sleep(1e-3)
    return found()


def outlet(
    *pressures: float, vent: bool = False, cut: bool = False, openings: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
) -> Outlet:
    """Setpoints [Pa] of the first chambers, 0 of the others."""
    values = np.array([*pressures, *[0.0] * (4 - len(pressures))])
    return Outlet(time.monotonic_ns(), vent, cut, values, np.array(openings))


VENT = outlet(vent=True)


class Bench:
    """A board, what its sensors show, and what it did with its valves last."""

    def __init__(self) -> None:
        self.pressures: Array = np.zeros(16)
        self.drive: Drive | None = None
        self.peer = BoardPeer(lambda: self.pressures, self._take)
        self._devices: list[SerialBoard] = []
        self._lock = threading.Lock()

    def _take(self, drive: Drive) -> None:
        self.drive = drive

    @property
    def vented(self) -> bool:
        return self.drive is not None and self.drive.vent

    def device(self, chambers: tuple[int, ...] = (0, 1, 2, 3), raw: bool = False) -> SerialBoard:
        """The driver, open."""
        device = SerialBoard(SerialOptions(port=str(self.peer.options["port"])), chambers, raw)
        self._devices.append(device)
        device.open()
        return device

    def driven(self, chambers: tuple[int, ...] = (0, 1, 2, 3), raw: bool = False) -> SerialBoard:
        """The driver, open and vented once: the board obeys."""
        device = self.device(chambers, raw)
        answer(device, VENT)
        return device

    def close(self) -> None:
        for device in self._devices:
            device.close()
        self.peer.close()


def answer(device: SerialBoard, asked: Outlet, patience: float = 20.0) -> Reading:
    """The board's answer; again where this machine was too busy for one in time, however long it pauses [s]."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        found = device.exchange(asked, 0.1)
        if found is not None:
            return found
    raise AssertionError("the board says nothing")


def stays(device: SerialBoard, asked: Outlet, seconds: float) -> list[Reading]:
    """What the board answers while `asked` is said for so long."""
    found, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        found.append(answer(device, asked))
        time.sleep(device.period)
    return found


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench()
    try:
        made.peer.plug()
        yield made
    finally:
        made.close()


Begin = Callable[..., tuple[FarEnd, SerialBoard]]


@pytest.fixture
def far_end() -> Iterator[Begin]:
    """Makes a far end that answers so, after a delay [s], and a driver for it with these options, not yet open."""
    made: list[tuple[FarEnd, SerialBoard]] = []

    def begin(answers: Answers, delay: float = 0.0, **options: float) -> tuple[FarEnd, SerialBoard]:
        end = FarEnd(answers, delay)
        asked = SerialOptions.model_validate({"port": end.port, "hello_timeout": 0.5, "timeout": 0.02, **options})
        made.append((end, SerialBoard(asked, (0, 1, 2, 3), False)))
        return made[-1]

    yield begin
    for end, device in made:
        device.close()
        end.close()
