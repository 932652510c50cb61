"""The virtual Modbus terminal itself, where no driver is asked."""

import gc
import socket
import threading
import time
from contextlib import suppress
from typing import Any

import pytest

from controller.virtual.modbus_server import ModbusPeer
from tests.controller.drivers.commands import Plant


def test_a_peer_that_is_unplugged_while_others_connect_leaves_no_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver that connects again at that very moment: its socket was collected later, in some other test."""
    plant, left = Plant(), list[Any]()
    peer = ModbusPeer(plant.read, plant.take)
    peer.plug()  # it keeps its port
    monkeypatch.setattr("sys.unraisablehook", left.append)
    at, over = ("127.0.0.1", int(peer.options["port"])), threading.Event()

    def connect() -> None:
        while not over.is_set():
            with suppress(OSError):
                socket.create_connection(at, 0.2).close()

    callers = [threading.Thread(target=connect) for _ in range(2)]
    for caller in callers:
        caller.start()
    for _ in range(3):
        peer.plug()
        time.sleep(0.03)
        peer.unplug()
    over.set()
    for caller in callers:
        caller.join()
    gc.collect()
    assert left == []
