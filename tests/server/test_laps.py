"""Laps: how a reference is closed, and the rows that lead the rig into it."""

import numpy as np
import pytest

from controller.actuator import PRESETS
from controller.errors import ParameterError
from controller.kernels.rod import Array
from controller.link import ENDLESS
from controller.parameters import RigParameters
from controller.reference.library import reference, static_map
from controller.reference.reach import static_tips
from controller.reference.reference import Reference
from server.runs.laps import APPROACH, SHORT_APPROACH, Lap, Place, first_leg, lap_of, next_leg

RIG = RigParameters()
SMAP = static_map(RIG.actuator, RIG.controller)


def lap(name: str, laps: int | None, actuator: str = "P1") -> tuple[Reference, Lap]:
    rig = RigParameters(actuator=PRESETS[actuator])
    found = reference(name, rig.actuator)
    return found, lap_of(found, rig, laps)


def jump(p: Array) -> float:
    """Longest way of a tick, from the last row to the first included [m]."""
    return float(np.linalg.norm(np.diff(np.vstack([p, p[:1]]), axis=0), axis=1).max())


def test_once_is_the_reference_itself_from_rest_on() -> None:
    whole, once = lap("vu", 1)
    leg = first_leg(SMAP, once, 1, np.zeros(2))
    assert leg.p == pytest.approx(whole.p, abs=1e-9)
    assert (leg.again, leg.ticks) == (whole.start, len(whole.p))


@pytest.mark.parametrize(("name", "rows"), [("circle_0.25hz", 4000), ("circle_1hz", 7000), ("circle_2hz", 4000)])
def test_a_periodic_reference_is_cut_to_whole_periods(name: str, rows: int) -> None:
    whole, found = lap(name, None)
    assert (len(found.p), found.back, found.rows(3)) == (rows, 0, 3 * rows)
    assert np.linalg.norm(found.p[0] - found.p[-1]) == pytest.approx(np.linalg.norm(found.p[1] - found.p[0]), rel=0.01)
    assert found.frequency == (whole.frequency, whole.frequency)


def test_a_path_that_ends_where_it_begins_needs_no_way_back() -> None:
    whole, found = lap("digit_0", 2)
    assert (len(found.p), found.back) == (len(whole.p) - whole.start - 1, 0)


def test_an_open_path_goes_back_in_u_between_its_laps_but_not_after_the_last() -> None:
    whole, found = lap("vu", 2)
    assert found.back == APPROACH - 1
    assert found.rows(2) == 2 * (len(whole.p) - whole.start) + found.back
    assert found.rows(None) == ENDLESS
    assert jump(found.p) < 0.5e-3, "0.5 m/s"
    assert found.frequency is None


def test_steps_repeat_as_they_are_after_the_wait_for_the_first() -> None:
    whole, found = lap("step", 3)
    assert (len(found.lead), len(found.p), found.back) == (3000, 12_000, 0)
    leg = first_leg(SMAP, found, 3, np.zeros(2))
    assert (leg.again, leg.ticks) == (whole.start, whole.start + 36_000)


def test_the_approach_begins_where_the_rig_is() -> None:
    u = np.array([-0.02, 0.03])
    _, found = lap("circle_1hz", 2)
    leg = first_leg(SMAP, found, 2, u)
    assert leg.p[0] == pytest.approx(static_tips(SMAP, u))
    assert np.linalg.norm(np.diff(leg.p[: APPROACH + 1], axis=0), axis=1).max() < 0.5e-3
    assert np.array_equal(leg.at(np.array([APPROACH, APPROACH + 7000])), found.p[[0, 0]])


def test_after_a_pause_the_rows_go_on_where_they_were_left() -> None:
    _, found = lap("circle_1hz", 3)
    here = np.array([0.02, 0.02])
    leg = next_leg(SMAP, found, 3, here, Place(9100, here))
    assert (leg.again, leg.done, leg.ticks) == (SHORT_APPROACH, 9100, SHORT_APPROACH + 3 * 7000 - 9100)
    assert np.array_equal(leg.at(SHORT_APPROACH + np.array([0, 4899, 4900])), found.p[[2100, 6999, 0]])
    far = next_leg(SMAP, found, None, -here, Place(9100, here))
    assert far.again == APPROACH
    assert far.ticks > 10**15
    begun = next_leg(SMAP, found, 3, here, Place(0, here))
    assert (begun.again, begun.ticks) == (APPROACH, APPROACH + 21_000)


def test_a_lap_that_the_rig_cannot_hold_is_refused() -> None:
    p = np.tile(static_tips(SMAP, np.array([0.02, 0.02])), (299_000, 1))
    with pytest.raises(ParameterError, match="take 301 s, the rig's memory holds 300 s"):
        lap_of(Reference("long", p, 0), RIG, 1)
