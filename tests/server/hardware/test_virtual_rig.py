"""A rig over real wires, on a simulated plant in a process of its own, as an operator has it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import TendrilError
from controller.realtime.ring import find_ring
from controller.schema.hardware import Frame
from controller.schema.modes import Cause, Law, Mode
from controller.schema.rig_file import read_rig_file
from controller.virtual.firmware import compiler
from controller.virtual.process import VirtualProcess
from controller.virtual.rig import seen_by_camera
from server.campaign.rows.wires import MODBUS, SERIAL
from server.campaign.waiting import wait
from tests.server.virtual_stack import Stack, stack

pytestmark = [
    pytest.mark.alone,
    pytest.mark.keyed(
        "controller",
        "firmware",
        "server/hardware/commissioning",
        "server/hardware",
        "server/campaign",
        "tests/server/virtual_stack.py",
        imports=False,
    ),
]

TASK = "vertical_1hz"
"""Short, and fast enough that a delay would show."""


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(SERIAL, id="natnet-serial", marks=pytest.mark.skipif(compiler() is None, reason="no compiler")),
        pytest.param(MODBUS, id="natnet-modbus"),
    ],
)
def test_a_task_over_real_wires_ends_as_the_twin_foresaw_and_a_lost_board_stops_it(text: str, tmp_path: Path) -> None:
    with stack(tmp_path, text) as one:
        _nothing_moves_without_devices(one)
        one.arm()
        foreseen = one.person.ask("POST", "/api/preview", reference=TASK)["rmse"]
        found = one.run(TASK)
        assert (found["state"], found["reason"]) == ("done", "")
        assert 0.7 < found["rmse"] / foreseen < 1.3
        _times_of_capture_are_true(one)
        _a_lost_board_stops_and_stays(one)


@pytest.mark.parametrize("line", ['late "0.03', "late '0.03", '"', "late 0.03\\", "late 0.03\udcff", "\udcfe\udcff"])
def test_a_line_that_cannot_be_read_is_refused_and_breaks_nothing(wires: VirtualProcess, line: str) -> None:
    with pytest.raises(TendrilError, match="the virtual rig: "):
        wires.do(line)
    wires.do("late 0.03")


@pytest.fixture(scope="module")
def wires(tmp_path_factory: pytest.TempPathFactory) -> Iterator[VirtualProcess]:
    virtual = VirtualProcess(MODBUS, tmp_path_factory.mktemp("wires"))
    yield virtual
    virtual.stop()


TURNED = Frame(axes=((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), origin=(0.1, -0.2))
"""How the camera really lies."""
BEFORE = {"drivers": "running", "jog": "u1+ u1- u2+ u2-"}
"""What was commissioned before."""


def test_the_frame_is_found_by_touching_base_tip_and_a_bent_pose(tmp_path: Path) -> None:
    table = f"[motion_capture.frame]\naxes = {[list(axis) for axis in TURNED.axes]}\norigin = {list(TURNED.origin)}\n"
    believed = {"motion_capture.frame": {}, "commissioned": BEFORE}
    with stack(tmp_path, MODBUS + table, believed) as one:
        assert one.virtual is not None
        wait(lambda: all(each["state"] == "running" for each in one.drivers().values()), 20.0, "devices that run")
        one.person.ask("POST", "/api/commissioning/frame/start", repeats=1)
        one.virtual.do("wand 0 0")
        _capture(one, "base", "#11")
        one.virtual.do("wand off")
        _capture(one, "tip", "#10")
        _capture(one, "bent", "#10")
        wait(lambda: _step(one, "frame")["state"] != "running", 20.0, "a frame")
        assert _step(one, "frame")["state"] == "done", _step(one, "frame")["result"]
        one.person.ask("POST", "/api/commissioning/frame/accept")
        found = read_rig_file(one.virtual.path).motion_capture.frame
    assert found.measured
    rest = 0.0375  # [rad] the twin keeps some of past bends, and the tip at rest is where the model has it
    assert np.abs(np.array(found.axes) - TURNED.axes).max() < rest + 0.01
    assert np.hypot(*(np.array(found.axes) @ seen_by_camera(np.zeros((1, 2)), TURNED)[0] + found.origin)) < 1e-3


def test_valves_that_may_do_little_bound_what_is_asked_and_stop_nothing(tmp_path: Path) -> None:
    low = 60e3
    with stack(tmp_path, MODBUS.replace('driver = "modbus"', f'driver = "modbus"\npressure_max = {low}')) as one:
        one.arm()
        one.person.ask("PATCH", "/api/settings", changes={"law": Law.OPEN_LOOP, "u_open": [0.05, -0.05]})
        one.person.command("follow", target=(0.2, 0.0))
        ring = find_ring(one.name)
        wait(lambda: ring.newest()["pressure_cmd"][0] > 0.99 * low, 20.0, "full torque")
        begin = ring.head
        wait(lambda: ring.head > begin + 2000, 20.0, "two seconds of it")
        rows = ring.read(begin, 2000)[1]
        assert set(rows["mode"].tolist()) == {Mode.FOLLOW}
        assert rows["pressure_cmd"].max() <= low * (1 + 1e-9)


def _capture(one: Stack, place: str, point: str) -> None:
    one.person.ask("PUT", "/api/commissioning/frame/capture", place=place, point=point)


def _step(one: Stack, name: str) -> dict[str, Any]:
    steps = one.person.ask("GET", "/api/commissioning")["steps"]
    return next(step for step in steps if step["name"] == name)


def _nothing_moves_without_devices(one: Stack) -> None:
    """ARM is refused, and the refusal says which device is missing and why."""
    assert one.virtual is not None
    one.virtual.do("unplug camera")
    wait(lambda: one.drivers()["motion_capture"]["state"] != "running", 10.0, "a camera that is missed")

    def is_refused() -> bool:
        answer = one.person.request("POST", "/api/command", request="arm")
        if answer.status_code == 503:  # not a word in time, on a busy machine: who operates asks again
            return False
        assert answer.status_code == 409 and "motion capture (natnet)" in answer.json()["detail"], answer.text
        return True

    wait(is_refused, 10.0, "an answer to ARM")
    one.virtual.do("plug camera")


def _times_of_capture_are_true(one: Stack) -> None:
    """The latency that is shown is that which was injected."""
    assert one.virtual is not None
    one.virtual.do("late 0.03")
    wait(lambda: 0.028 < one.drivers()["motion_capture"]["latency"] < 0.04, 10.0, "the injected latency", 0.2)
    one.virtual.do("mend")


def _a_lost_board_stops_and_stays(one: Stack) -> None:
    """E-STOP, latched; only a fresh action moves anything again."""
    assert one.virtual is not None
    one.virtual.do("unplug valves")
    ring = find_ring(one.name)
    wait(lambda: (row := ring.newest()) is not None and row["mode"] == Mode.E_STOP, 5.0, "the E-STOP")
    row = ring.newest()
    assert row is not None and row["cause"] == Cause.PRESSURES_LOST
    assert not row["pressure_cmd"].any()
    one.virtual.do("plug valves")
    one.arm()
    assert one.person.command("follow", target=(0.2, 0.05))["accepted"]
    wait(lambda: np.hypot(*(ring.newest()["p_meas"] - (0.2, 0.05))) < 5e-3, 10.0, "the tip at the target")  # type: ignore[index]
