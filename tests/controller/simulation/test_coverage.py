"""Intervals of what a rig measures of itself hold the truth as often as they say."""

import pytest

from tests.controller.coverage import pneumatics, swings

pytestmark = pytest.mark.keyed()

TIMES = 20
"""`python -m tests.controller.coverage` asks 200 times."""


@pytest.mark.parametrize("repeats", [2, 6])
def test_those_of_the_first_mode(repeats: int) -> None:
    for found in swings(repeats, 1e-4, TIMES):
        assert found.held >= 0.8, found
        assert abs(found.bias) < 2e-3, found


def test_those_of_dead_time_and_lag() -> None:
    for found in pneumatics(300.0, TIMES):
        assert found.held >= 0.8, found
        assert abs(found.bias) < 1e-3, found
