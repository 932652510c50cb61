"""Laps: how a reference is closed, and the rows that lead the rig into it."""

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.link import ENDLESS
from controller.reference.feasible.reach import static_tips
from controller.reference.library import reference
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.parameters import RigParameters
from server.runs.lap import Lap, Place
from server.runs.laps import first_leg, lap_of, next_leg

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
    assert leg.p[leg.again :] == pytest.approx(whole.p[whole.start :], abs=1e-9)
    assert static_tips(SMAP, leg.u) == pytest.approx(leg.p, abs=2e-4)
    assert leg.p[0] == pytest.approx(whole.p[0])
    assert leg.ticks == len(leg.p) and leg.travel.sum() == leg.again
    fastest = np.linalg.norm(np.diff(leg.p[: leg.again], axis=0), axis=1).max() / 1e-3
    assert 0.15 < fastest <= 0.2 * (1.0 + 1e-6), "the way there keeps within the settings' 0.2 m/s"


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
    assert found.back >= 1999 and found.travel[-found.back :].all() and not found.travel[: -found.back].any()
    assert found.rows(2) == 2 * (len(whole.p) - whole.start) + found.back
    assert found.rows(None) == ENDLESS
    assert jump(found.p) <= 0.2e-3 * (1.0 + 1e-6), "0.2 m/s"
    assert found.frequency is None


def test_steps_repeat_as_they_are_after_the_wait_for_the_first() -> None:
    whole, found = lap("step", 3)
    assert (len(found.lead), len(found.p), found.back) == (3000, 12_000, 0)
    leg = first_leg(SMAP, found, 3, np.zeros(2))
    assert leg.ticks == leg.again + 36_000 and leg.steps
    assert np.array_equal(leg.p[leg.again - 3000 : leg.again], whole.p[whole.start - 3000 : whole.start])


def test_the_approach_begins_where_the_rig_is() -> None:
    u = np.array([-0.02, 0.03])
    _, found = lap("circle_1hz", 2)
    leg = first_leg(SMAP, found, 2, u)
    assert leg.p[0] == pytest.approx(static_tips(SMAP, u))
    assert np.linalg.norm(np.diff(leg.p[: leg.again + 1], axis=0), axis=1).max() <= 0.2e-3 * (1.0 + 1e-6)
    assert np.array_equal(leg.at(leg.again + np.array([0, 7000])), found.p[[0, 0]])


def test_after_a_pause_the_rows_go_on_where_they_were_left() -> None:
    _, found = lap("circle_1hz", 3)
    here = np.array([0.02, 0.02])
    there = found.torques[2100]
    leg = next_leg(SMAP, found, 3, there, Place(9100, there))
    assert (leg.done, leg.ticks) == (9100, leg.again + 3 * 7000 - 9100)
    assert 500 < leg.again < 2000, "half a second back to the path, and a run-up on it"
    assert np.array_equal(leg.at(leg.again + np.array([0, 4899, 4900])), found.p[[2100, 6999, 0]])
    assert leg.travel[: leg.again].all() and not leg.travel[leg.again :].any()
    far = next_leg(SMAP, found, None, -here, Place(9100, there))
    assert far.again > 2000
    assert far.ticks > 10**15
    begun = next_leg(SMAP, found, 3, here, Place(0, here))
    assert begun.again >= 2000 and begun.ticks == begun.again + 21_000


def test_a_lap_that_the_rig_cannot_hold_is_refused() -> None:
    p = np.tile(static_tips(SMAP, np.array([0.02, 0.02])), (299_000, 1))
    with pytest.raises(ParameterError, match=r"take 302\.5 s, the rig's memory holds 300 s"):
        lap_of(Reference("long", p, 0), RIG, 1)
