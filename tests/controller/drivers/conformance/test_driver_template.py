import re
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from controller.drivers.conformance import Bench, check_driver
from controller.drivers.conformance.bench import Driven
from controller.drivers.conformance.suite import CAPTURE, FIRST, LAST, VALVES
from controller.drivers.registry import driver_class
from controller.schema.hardware import CHANNELS
from controller.system.origin import ROOT
from controller.virtual.bench import Chambers
from controller.virtual.peers import Drive

PAGE = (ROOT / "docs" / "drivers.md").read_text()
WATCHDOG_S = 0.2


class LineBoard:
    """The board of docs/drivers.md: lines over TCP, a watchdog of 0.2 s."""

    def __init__(self) -> None:
        self.chambers = Chambers()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._port = self._listener.getsockname()[1]
        self._listener.close()
        self._listening = False
        self._speaks = True
        self._connections: list[socket.socket] = []
        self._heard = 0.0

    @property
    def options(self) -> dict[str, str | int]:
        return {"host": "127.0.0.1", "port": self._port}

    def plug(self) -> None:
        self._speaks = True
        if not self._listening:
            self._listener = socket.create_server(("127.0.0.1", self._port))
            self._listening = True
            threading.Thread(target=self._accept, args=(self._listener,), name="conformance-board", daemon=True).start()

    def unplug(self) -> None:
        self._listening = False
        for one in (self._listener, *self._connections):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            one.close()
        self._connections.clear()

    def silence(self) -> None:
        self._speaks = False

    def driven(self) -> Driven:
        if time.monotonic() - self._heard > WATCHDOG_S:
            self._tell(np.zeros(CHANNELS), True)
        return self.chambers.drive

    def _tell(self, pressures: Any, vent: bool) -> None:
        self.chambers.take(Drive(pressures, np.zeros(CHANNELS), False, vent, vent))

    def _accept(self, listener: socket.socket) -> None:
        while True:
            try:
                connection = listener.accept()[0]
            except OSError:
                return
            self._connections.append(connection)
            threading.Thread(target=self._serve, args=(connection,), name="conformance-board", daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        try:
            with connection, connection.makefile("rwb", 0) as lines:
                for line in lines:
                    if self._speaks:
                        self._obey(line.split())
                        said = " ".join(f"{value:.0f}" for value in self.chambers.pressures()[:4])
                        lines.write(f"P {said}\n".encode())
        except OSError:
            pass

    def _obey(self, words: list[bytes]) -> None:
        self._heard = time.monotonic()
        pressures = np.zeros(CHANNELS)
        if words[0] == b"S":
            pressures[:4] = [float(word) for word in words[1:]]
        self._tell(pressures, words[0] == b"V")


@pytest.fixture
def board() -> Iterator[Bench]:
    board = LineBoard()
    yield board
    board.unplug()


def template() -> str:
    found = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


def test_the_template_has_at_most_60_lines_and_passes_every_check(board: Bench) -> None:
    source = template()
    assert len(source.splitlines()) <= 60
    names: dict[str, Any] = {"__name__": "labboard"}
    exec(compile(source, "labboard.py", "exec"), names)
    rows = check_driver(names["LabBoard"], {}, board)
    assert [row for row in rows if row.passed is not True] == []


def test_the_page_names_every_check() -> None:
    named = re.findall(r"^\| ([a-z ]+?)(?: \((?:capture|valves)\))? \| .* \|$", PAGE, re.MULTILINE)
    assert {*FIRST, *CAPTURE, *VALVES, *LAST} <= set(named)


@pytest.mark.parametrize(("driver", "page"), [("modbus", "modbus"), ("nidaq", "modbus"), ("udp", "udp")])
def test_the_pages_name_every_option(driver: str, page: str) -> None:
    text = (ROOT / "docs" / f"{page}.md").read_text()
    missing = [name for name in driver_class(driver).Options.model_fields if f"`{name}`" not in text]
    assert missing == []
