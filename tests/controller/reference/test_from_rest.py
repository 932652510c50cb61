"""On which of two branches a path leaves rest."""

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.kernels.control.inverse import REFINE_STEPS, TOLERANCE
from controller.reference.feasible.approach import branch, follow
from controller.reference.feasible.from_rest import leaving_rest
from controller.reference.library import reference
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters


def coarse(p: Array, every: int) -> Array:
    """Every few rows of p (n, 2), joined by straight lines."""
    at = np.arange(len(p))
    return np.column_stack([np.interp(at, at[::every], p[::every, j]) for j in range(2)])


@pytest.mark.parametrize("actuator", ["P1", "P2", "P3"])
@pytest.mark.parametrize("name", ["circle_1hz", "vu", "step"])
def test_rounded_and_coarse_points_leave_rest_on_the_library_s_branch(actuator: str, name: str) -> None:
    smap = static_map(PRESETS[actuator], ControllerParameters())
    p = reference(name, PRESETS[actuator]).p
    wanted = branch(smap, p[2000:])
    for given in (p, p.round(6), p.round(5), p.round(4), coarse(p, 10)):
        led = leaving_rest(smap, given)
        assert np.abs(follow(smap, led[:2001], np.zeros(2), REFINE_STEPS)[0][-1] - wanted).max() < 1e-3
        assert np.abs(led - given).max() < TOLERANCE
    assert leaving_rest(smap, p) is p


def test_an_approach_that_is_no_reference_of_ours_leaves_on_the_same_branch() -> None:
    """Straight, and around the base: neither is a motion of the arm."""
    smap = static_map(PRESETS["P1"], ControllerParameters())
    shape = reference("circle_1hz", PRESETS["P1"]).p[2000:]
    s = np.arange(2000)[:, None] / 2000
    s = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    rest, to = np.array([0.253, 0.0]), shape[0]
    r, turn = 0.253 + s * (np.hypot(*to) - 0.253), s * np.arctan2(to[1], to[0])
    for lead in (rest + s * (to - rest), r * np.hstack([np.cos(turn), np.sin(turn)])):
        led = leaving_rest(smap, np.vstack([lead, shape]))
        end = follow(smap, led[:2001], np.zeros(2), REFINE_STEPS)[0][-1]
        assert end == pytest.approx(branch(smap, shape), abs=1e-3)
        assert np.abs(led[:2000] - lead).max() < 3e-3 and (led[2000:] == shape).all()


def test_a_path_that_stays_at_rest_is_left_alone() -> None:
    smap = static_map(PRESETS["P1"], ControllerParameters())
    p = np.tile([0.253, 0.0], (100, 1))
    assert leaving_rest(smap, p) is p
