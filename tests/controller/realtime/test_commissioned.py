"""A rig of devices, over real wires: what it refuses until drivers, chambers, frame and signs are accepted."""

import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np
import pytest

from controller.realtime.command_handler import UNCOMMISSIONED
from controller.schema.commissioned import Commissioned
from controller.schema.hardware import CHANNELS, Hardware, MotionCapture, Valves
from controller.schema.modes import Law, Mode, Request
from controller.schema.parameters import RigParameters, SafetyLimits, Settings
from controller.virtual.modbus_server import ModbusPeer
from controller.virtual.registry import capture_peer
from tests.controller.drivers.commands import Plant
from tests.controller.live_rig import LiveRig, live_rig, wait_for

pytestmark = pytest.mark.alone

TIP = np.array([[0.24, 0.0, 0.0]])
BLIND = Settings(law=Law.OPEN_LOOP, sensed=0)
CLOSED = Settings(law=Law.FF_PI)
PATIENT = SafetyLimits(loop_gap=0.4, operator_timeout=5.0, pressures_lost=5.0, measurement_lost=5.0)


@contextmanager
def rig_of_devices(folder: Path, commissioned: Commissioned, plant: Plant | None = None) -> Iterator[LiveRig]:
    camera, plant, over = capture_peer("json", {}), plant or Plant(), threading.Event()
    valves = ModbusPeer(plant.read, plant.take)

    def film() -> None:
        while not over.wait(0.01):
            camera.show(time.monotonic_ns(), TIP, ("tip",))

    camera.plug()
    valves.plug()
    with closing(valves):
        filming = threading.Thread(target=film)
        filming.start()
        hardware = Hardware(
            motion_capture=MotionCapture(driver="json", options=dict(camera.options), labels={"tip": 10}),
            valves=Valves(driver="modbus", options=dict(valves.options)),
            commissioned=commissioned,
        )
        try:
            with live_rig(folder, parameters=RigParameters(hardware=hardware, limits=PATIENT)) as rig:
                devices = rig.operator.client.drivers
                wait_for(lambda: all(one.state == "running" and not one.detail for one in devices().drivers))
                yield rig
        finally:
            over.set()
            filming.join()
            camera.unplug()


def test_it_is_armed_for_the_steps_of_its_commissioning_only_and_in_open_loop_only(tmp_path: Path) -> None:
    with rig_of_devices(tmp_path, "missing") as rig:
        operator = rig.operator
        for settings, step in ((CLOSED, 0), (CLOSED, 1), (BLIND, 0)):
            reply = operator.send(Request.ARM, settings=settings, commissioning=step)
            assert (reply.accepted, reply.detail, reply.mode) == (False, UNCOMMISSIONED, Mode.VENTED)
        assert operator.send(settings=CLOSED).accepted, "while it is vented any settings may wait"
        assert operator.send(Request.ARM, settings=BLIND, commissioning=1).mode == Mode.HOLD
        for request in (Request.NONE, Request.HOLD, Request.FOLLOW):
            reply = operator.send(request, settings=CLOSED, target=(0.24, 0.0), commissioning=1)
            assert (reply.accepted, reply.detail, reply.mode) == (False, UNCOMMISSIONED, Mode.HOLD)
        last = rig.ring().newest()
        assert last is not None and last["law"] == Law.OPEN_LOOP
        assert operator.send(Request.FOLLOW, settings=BLIND, target=(0.24, 0.0)).accepted
        assert operator.send(Request.REST, settings=CLOSED).accepted, "what ends motion is never refused"


@pytest.mark.parametrize("commissioned", ["accepted", "waived"])
def test_with_all_of_it_accepted_or_waived_it_arms(tmp_path: Path, commissioned: Commissioned) -> None:
    with rig_of_devices(tmp_path, commissioned) as rig:
        assert rig.operator.send(Request.ARM, settings=CLOSED).mode == Mode.HOLD
        assert rig.operator.client.info is not None and rig.operator.client.info.parameters.hardware is not None
        assert rig.operator.client.info.parameters.hardware.commissioned == commissioned


def test_it_is_not_armed_while_a_vented_chamber_holds_pressure(tmp_path: Path) -> None:
    """A valve that is stuck, or a supply that leaks through: "vented" is what the valves were told."""
    plant, held = Plant(), np.eye(CHANNELS)[2]
    with rig_of_devices(tmp_path, "accepted", plant) as rig:
        plant.sensed = held * 62e3
        wait_for(lambda: (row := rig.ring().newest()) is not None and row["pressure_meas"][2] > 60e3)
        reply = rig.operator.send(Request.ARM, settings=CLOSED)
        assert (reply.accepted, reply.mode) == (False, Mode.VENTED)
        assert reply.detail == (
            "refused: u2+ holds 62 kPa though it is vented: wait until it is empty, or see to its valve and its supply"
        )
        plant.sensed = held * 5e3
        wait_for(lambda: (row := rig.ring().newest()) is not None and row["pressure_meas"][2] < 6e3)
        assert rig.operator.send(Request.ARM, settings=CLOSED).mode == Mode.HOLD
