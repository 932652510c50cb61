"""What the samples of the markers tell: motion, and a camera that shows the past."""

import numpy as np
import pytest

from controller.drivers.twin import inject
from controller.schema.messages import TwinFaults
from controller.schema.modes import Cause, Freeze, Law, Mode
from tests.controller.desk import Desk
from tests.controller.trial import Trial, line

ROD_6 = 5


@pytest.mark.parametrize("name", ["P1", "P3"])
def test_a_frozen_camera_is_noticed_though_a_marker_that_is_not_used_has_jumped(name: str) -> None:
    trial = Trial(name)
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    jumped = {"jump": (0.0, 0.05), "rods": 1 << ROD_6}
    inject(TwinFaults(**jumped), trial.twin.faults)
    assert (trial.run(200)["mode"] == Mode.FOLLOW).all()
    inject(TwinFaults(**jumped, freeze=Freeze.FRESH_TIME), trial.twin.faults)
    rows = trial.drag(line((0.12, 0.1), (0.12, -0.1), 40), 4.0)
    first = np.flatnonzero(rows["mode"] != Mode.FOLLOW)
    assert first.size and rows["cause"][first[0]] == Cause.MEASUREMENT_FROZEN


def test_a_marker_has_moved_that_is_elsewhere_than_where_it_was_seen_last_used_or_not() -> None:
    desk = Desk(law=Law.FF)
    desk.into(Mode.HOLD)
    state = desk.rig.control.state[0]

    def moved(step: int = 1) -> bool:
        """Whether a sample of the next `step` ms tells of motion."""
        before = int(state["moved_ns"])
        desk.step(step)
        return int(state["moved_ns"]) != before

    assert moved()
    desk.still, desk.markers[ROD_6, 1] = True, 0.05
    assert moved() and desk.rig.sensing.dropped[0] == 1 << ROD_6
    assert not moved(20)
    desk.markers[ROD_6, 1] += 1e-9
    assert moved() and not moved(20)
    desk.markers[2] = np.nan
    assert not moved(20), "out of sight"
    desk.markers[2] = 3 * 0.0253, 0.0
    assert not moved(20), "where it was"
    desk.markers[2, 0] += 1e-9
    assert moved() and not moved(20)
    assert desk.mode == Mode.HOLD
