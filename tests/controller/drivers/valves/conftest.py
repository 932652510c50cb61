"""A virtual terminal on Modbus TCP, and the plant behind it."""

from collections.abc import Iterator

import pytest

from controller.virtual.modbus_server import ModbusPeer
from tests.controller.drivers.commands import Plant


@pytest.fixture
def plant() -> Plant:
    return Plant()


@pytest.fixture
def peer(plant: Plant) -> Iterator[ModbusPeer]:
    peer = ModbusPeer(plant.read, plant.take)
    peer.plug()
    yield peer
    peer.unplug()
