"""The chambers' answers to steps: the twin's, and ones with a known lag."""

from itertools import pairwise

import numpy as np
import pytest

from controller.research.experiments.pressure_steps import SETPOINTS, measured, pressure_steps
from controller.schema.parameters import RigParameters, TwinParameters

pytestmark = pytest.mark.keyed()


def test_a_first_order_lag_after_a_dead_time_is_measured_as_such() -> None:
    t = 1e-3 * np.arange(1500)
    p = 60e3 + 40e3 * (1.0 - np.exp(-np.clip(t - 0.05, 0.0, None) / 0.04))
    found = measured(60e3, 100e3, p)
    assert found.dead_time == pytest.approx(0.05, abs=2e-3)
    assert found.dead_time + found.t63 == pytest.approx(0.05 + 0.04, abs=1.1e-3)
    assert found.rises and not measured(100e3, 60e3, 160e3 - p).rises


def test_a_chamber_that_does_not_move_has_no_times() -> None:
    found = measured(0.0, 1e3, np.zeros(100))
    assert np.isnan(found.dead_time) and np.isnan(found.t63)


def test_the_twins_chambers_reach_every_setpoint_after_their_dead_time() -> None:
    steps = pressure_steps(RigParameters(twin=TwinParameters(dead_time=0.08)))
    assert [(step.begin, step.end) for step in steps] == list(pairwise(SETPOINTS))
    for step in steps:
        assert 0.08 <= step.dead_time < 0.09
        assert step.pressure[-1] == pytest.approx(step.end, abs=500.0)
        assert step.pressure[0] == pytest.approx(step.begin, abs=500.0)


def test_the_wish_for_a_lag_is_heard_in_its_own_direction_only() -> None:
    slow = pressure_steps(RigParameters(twin=TwinParameters(exhaust_time=0.2)))
    for usual, other in zip(pressure_steps(RigParameters()), slow, strict=True):
        if usual.rises:
            assert other.t63 == pytest.approx(usual.t63, abs=3e-3)
        else:
            assert other.t63 > 1.5 * usual.t63
