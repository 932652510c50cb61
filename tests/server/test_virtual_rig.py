"""A rig over real wires, on a simulated plant in a process of its own, as an operator has it."""

from pathlib import Path

import numpy as np
import pytest

from controller.realtime.ring import find_ring
from controller.schema.modes import Cause, Mode
from controller.virtual.firmware import compiler
from server.campaign.rows.wires import MODBUS, SERIAL
from server.campaign.waiting import wait
from tests.server.virtual_stack import Stack, stack

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


def _nothing_moves_without_devices(one: Stack) -> None:
    """ARM is refused, and the refusal says which device is missing and why."""
    assert one.virtual is not None
    one.virtual.do("unplug camera")
    wait(lambda: one.drivers()["motion_capture"]["state"] != "running", 10.0, "a camera that is missed")
    refused = one.person.request("POST", "/api/command", request="arm")
    assert refused.status_code == 409
    assert "motion capture (natnet)" in refused.json()["detail"]
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
