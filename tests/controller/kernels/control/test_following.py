"""A target led by hand: no stop, and no swing that stays, whatever the arm's damping and the length of its air lines.

`python -m tests.controller.following` makes 500 clicks and 500 drags of each actuator, by each choice of sensors, on
each plant.
"""

import numpy as np
import pytest

from controller.schema.actuator import PRESETS
from controller.schema.modes import Integrator, Law, Mode, Request
from controller.schema.parameters import SENSORS, TwinParameters, usual_kappa
from tests.controller.few_markers import dragged
from tests.controller.following import SENSED, Came, Course, came_of, parameters
from tests.controller.trial import Trial, distance, true_tip, twin_with

pytestmark = pytest.mark.keyed()

CORNERS = ((0.1, 0.07), (0.352, 0.05), (0.5, 0.04))


@pytest.mark.parametrize("dragged", [False, True], ids=["clicked", "dragged"])
@pytest.mark.parametrize("sensed", ["tip", "rod 6", "rods 6 and 10"])
@pytest.mark.parametrize("name", PRESETS)
def test_a_target_led_anywhere_stops_no_rig_and_leaves_no_swing(name: str, sensed: str, dragged: bool) -> None:
    for seed, plant in enumerate(CORNERS):
        assert came_of(Course(name, sensed, *plant, dragged, seed), 8) == Came([], [])


@pytest.mark.parametrize(("seed", "dead_time"), [(0, 0.04), (1, 0.05), (2, 0.07)])
def test_a_hardly_damped_arm_of_which_only_the_middle_is_seen_is_led_fast(seed: int, dead_time: float) -> None:
    """P2 whipped by 100 mm, and was stopped for OSCILLATION: S of the way turned its integral into swinging torques."""
    assert came_of(Course("P2", "rod 6", 0.1, dead_time, True, seed), 20) == Came([], [])


def test_a_model_that_is_moved_over_is_no_swing_of_the_arm() -> None:
    """P2 by its third rod: the model was 150 mm off, and moved over in 0.2 s, which stopped the rig for OSCILLATION."""
    assert came_of(Course("P2", "rod 3", 0.5, 0.04, True, 6), 4) == Came([], [])


@pytest.mark.parametrize(("dragged", "seed", "dead_time"), [(True, 36, 0.04), (False, 20, 0.07)])
def test_at_an_edge_of_the_torques_the_estimate_does_not_drive_itself(
    dragged: bool, seed: int, dead_time: float
) -> None:
    """P1 in a pull, by rod 6: 5 mN m of integral beyond the edge, cut by an S that swung with the estimate."""
    assert came_of(Course("loaded", "rod 6", 0.1, dead_time, dragged, seed), 50) == Came([], [])


@pytest.mark.parametrize(("name", "sensed"), [("P1", "rod 2"), ("P2", "rod 3"), ("P2", "rod 4")])
def test_a_tip_that_is_hardly_told_of_is_hardly_corrected(name: str, sensed: str) -> None:
    """The model's own swing, fed back in full, drove the arm to and fro, and TRACKING_RMS stopped it."""
    assert came_of(Course(name, sensed, 0.5, 0.04, True, 78), 50) == Came([], [])


def test_one_marker_at_the_base_is_enough_with_the_inertia_that_a_twin_begins_with() -> None:
    """P2's estimate, by the table's inertia, was more than 80 mm off the reference for 2 s, which stopped the rig."""
    kappa = usual_kappa(PRESETS["P2"], Integrator.IMPLICIT)
    course = Course("P2", "rod 1", 0.352, 0.07, True, 77, kappa)
    came = dragged(parameters(course), course, SENSED["rod 1"], Law.FF_PI, 50)
    assert (came.stops, came.off) == (0, 0.0)


@pytest.mark.parametrize(("rods", "better"), [(3, 2.0), (6, 1.5), (SENSORS, 1.8)])
def test_with_the_plants_inertia_the_estimate_is_far_better(rods: int, better: float) -> None:
    """P2 dragged about under FF; half of its kappa, or the 1.4 of it that a measurement finds, are as good as it."""
    course, kappa = Course("P2", "tip", 0.352, 0.05, dragged=True, seed=5), TwinParameters().kappa
    told = [course._replace(observer_kappa=one) for one in (1.0, 0.5 * kappa, 1.4 * kappa)]
    table, *near = (dragged(parameters(one), one, 1 << rods >> 1, Law.FF, 3).estimate ** 0.5 for one in told)
    assert max(near) < table / better


@pytest.mark.parametrize("name", PRESETS)
def test_on_the_way_to_another_branch_nothing_is_fed_back(name: str) -> None:
    """A way through a fold, where S tells nothing: fed back there, the error drove the arm to and fro."""
    trial = Trial(name, sensed=1 << 5)
    trial.arm()
    trial.follow(-0.05, 0.12, 3.0)
    changed = False
    for target in [(-0.05, -0.12), (0.0, 0.15), (0.15, 0.0), (-0.06, -0.1), (0.1, 0.12)]:
        trial.command["target"] = target
        for _ in range(40):
            before = trial.rig.control.state[0]["blending"]
            rows = trial.run(50)
            after = trial.rig.control.state[0]["blending"]
            if before and after:
                changed = True
                assert np.abs(rows["integral"]).max() == 0.0
                assert np.abs(rows["u_fb"][-1]).max() <= np.abs(rows["u_fb"][0]).max() + 1e-12
        assert (rows["mode"] == Mode.FOLLOW).all()
    assert changed


def test_the_drag_that_once_stopped_the_rig_is_followed() -> None:
    """P1 by its tip to two points, then by rod 6 alone and fast to a third: FAULT in two of four tries, once."""
    for seed in range(4):
        trial = Trial(parameters=twin_with(seed=seed))
        trial.arm()
        trial.ask(Request.FOLLOW, (0.25, 0.0), 100)
        rows = [trial.drag([(-0.138, 0.025)], 2.5), trial.drag([(0.16, 0.15)], 2.5)]
        trial.switch(sensed=1 << 5)
        rows += [trial.drag([(0.16 + 0.03 * s, 0.15 - 0.12 * s) for s in np.linspace(0.1, 1.0, 10)], 0.16)]
        rows += [trial.run(6000)]
        every = np.concatenate(rows)
        assert (every["mode"] == Mode.FOLLOW).all()
        assert distance(true_tip(every)[-1000:], every["p_ref"][-1000:]).max() < 15e-3
