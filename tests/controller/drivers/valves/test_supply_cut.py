"""In E_STOP the supply stays cut whatever becomes of the loop: the valves' real thread, and each virtual board."""

import threading
import time
from collections.abc import Iterator

import pytest

from controller.drivers.device import Outlet
from controller.drivers.inlet import Inlet
from controller.drivers.registry import valve_device
from controller.drivers.threads import OUTLET_OLD_NS, ValveThread
from controller.schema.hardware import Valves
from controller.virtual.board import BoardPeer
from controller.virtual.firmware import compiler
from controller.virtual.peers import ValvePeer
from controller.virtual.registry import valve_peer
from tests.controller.drivers.commands import Plant, vented
from tests.controller.live_rig import wait_for

LOST = 0.8
"""By then every board has found by itself that its host is lost [s]."""


class Loop:
    """Makes a command whenever it is asked for one, until it stalls: then the last one grows old."""

    def __init__(self) -> None:
        self.cut, self.stalled = False, threading.Event()
        self._last = vented()

    def newest(self) -> Outlet:
        if not self.stalled.is_set():
            self._last = vented(self.cut)
        return self._last


@pytest.fixture
def plant() -> Plant:
    return Plant()


@pytest.fixture(
    params=[
        pytest.param("serial", marks=pytest.mark.skipif(compiler() is None, reason="no compiler")),
        "udp",
        "modbus",
    ]
)
def peer(request: pytest.FixtureRequest, plant: Plant) -> Iterator[ValvePeer]:
    peer = valve_peer(request.param, {}, plant.read, plant.take)
    peer.plug()
    yield peer
    peer.close()


@pytest.fixture
def loop(request: pytest.FixtureRequest, peer: ValvePeer, plant: Plant) -> Iterator[tuple[Loop, ValveThread]]:
    """In E_STOP, and its thread, which has told the board so."""
    name, loop = request.node.callspec.params["peer"], Loop()
    device = valve_device(Valves(driver=name, options=dict(peer.options)))
    thread = ValveThread(device, name, loop.newest, Inlet(lambda record: None))
    thread.start()
    wait_for(lambda: thread.ready and (name == "modbus" or not plant.drive.cut))  # as which a board begins
    loop.cut = True
    wait_for(lambda: plant.drive.cut)
    yield loop, thread
    thread.stop()


@pytest.mark.process
def test_a_loop_that_stalls_in_e_stop_connects_no_supply(loop: tuple[Loop, ValveThread], plant: Plant) -> None:
    before = len(plant.drives)
    loop[0].stalled.set()
    time.sleep(5e-9 * OUTLET_OLD_NS)
    assert plant.drive.vent and all(drive.cut for drive in plant.drives[before:])


@pytest.mark.process
def test_a_rig_that_ends_in_e_stop_connects_no_supply(loop: tuple[Loop, ValveThread], plant: Plant) -> None:
    before = len(plant.drives)
    loop[1].stop()
    time.sleep(LOST)
    assert plant.drive.vent and all(drive.cut for drive in plant.drives[before:])


@pytest.mark.process
def test_a_board_that_is_lost_and_found_in_e_stop_connects_no_supply(
    loop: tuple[Loop, ValveThread], peer: ValvePeer, plant: Plant
) -> None:
    before = len(plant.drives)
    peer.unplug()
    wait_for(lambda: not loop[1].ready)
    time.sleep(LOST)
    peer.plug()
    wait_for(lambda: loop[1].ready)
    assert plant.drive.vent and all(drive.cut for drive in plant.drives[before:])


@pytest.mark.process
def test_the_supply_is_connected_again_once_the_loop_says_so(loop: tuple[Loop, ValveThread], plant: Plant) -> None:
    if loop[1].status().driver == "modbus":
        pytest.skip("a terminal's dump valve cuts the supply with every vent")
    loop[0].cut = False
    wait_for(lambda: plant.drive.vent and not plant.drive.cut)


@pytest.mark.process
@pytest.mark.skipif(compiler() is None, reason="no compiler")
@pytest.mark.parametrize("peer", ["serial"], indirect=True)
def test_a_stop_that_is_pressed_while_nothing_is_driven_is_said_and_hinders_the_rig(
    loop: tuple[Loop, ValveThread], peer: BoardPeer
) -> None:
    peer.press_e_stop(True)
    wait_for(lambda: not loop[1].ready)
    assert loop[1].status().detail == "its hardware stop was pressed"
    peer.press_e_stop(False)
    wait_for(lambda: loop[1].ready)
