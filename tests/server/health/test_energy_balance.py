"""The row of the energy balance: of what the integrator does, and of nothing that a busy machine or a reset leaves."""

import math
from typing import Any

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.modes import Mode
from server.health.energy_balance import EnergyBalance
from tests.controller.trial import Trial

NEXT_TO_NOTHING = 2.1e-3
"""Of the energy that is stored and given back in every lap, with the paper's springs."""
ADDED, LOST = 1e-4, 5e-3
"""The same with those that a rig begins with: a backward step loses some of what they store, and adds none."""
BATCH = 17
"""Ticks of one batch of telemetry at 60 a second."""


@pytest.fixture(scope="module")
def circle() -> Rows:
    """With the paper's springs."""
    return turning(K_o=(100.0, 100.0), B_o=(0.0, 0.0))


def turning(**springs: Any) -> Rows:
    """12 s of a circle at 1 Hz, on the twin."""
    trial = Trial(**springs)
    x, y = trial.arm()["p_ref"][-1]
    trial.follow(x, y, 0.2)
    angle = np.linspace(0.0, 24.0 * np.pi, 600)
    rows = trial.drag([(x - 0.03 + 0.03 * math.cos(a), y + 0.03 * math.sin(a)) for a in angle], 12.0)
    rows["slot"] = rows["tick"]
    return rows


def fed(rows: Rows) -> EnergyBalance:
    balance = EnergyBalance()
    for start in range(0, len(rows), BATCH):
        balance.add(rows[start : start + BATCH])
    return balance


def test_in_fast_motion_the_integrator_adds_next_to_nothing(circle: Rows) -> None:
    assert np.ptp(circle["energy"]) > 40e-3, "it stores and gives back millijoules"
    assert abs(fed(circle).gained) < NEXT_TO_NOTHING * np.ptp(circle["energy"])


def test_with_the_springs_that_a_rig_begins_with_it_loses_some_and_adds_none() -> None:
    rows = turning()
    assert -LOST < fed(rows).gained / np.ptp(rows["energy"]) < ADDED


def test_an_integrator_that_adds_energy_is_seen_whenever_it_began(circle: Rows) -> None:
    leaking = circle.copy()
    leaking["ledger"] += 2e-3 * np.linspace(0.0, 1.2, len(leaking))
    assert fed(leaking).gained == pytest.approx(2e-3, rel=0.1)


def test_there_is_no_figure_before_ten_seconds(circle: Rows) -> None:
    assert math.isnan(fed(circle[:9_900]).gained) and math.isfinite(fed(circle[:10_600]).gained)


@pytest.mark.parametrize("what", ["lost", "reseated", "cleared"])
def test_what_a_moment_left_in_the_ledger_is_none_of_it(circle: Rows, what: str) -> None:
    rows, at = circle.copy(), 1_700
    rows["ledger"][at:] -= 70.958e-3  # as it stood on the page of a busy machine, in VENTED, too
    assert abs(fed(rows).gained) > 0.07
    if what == "lost":
        rows["slot"][at:] += 40
    elif what == "reseated":
        rows["reseats"][at:] += 1
    else:
        rows["mode"][at - 50 : at], rows["mode"][at:] = Mode.E_STOP, Mode.VENTED
    assert abs(fed(rows).gained) < NEXT_TO_NOTHING * np.ptp(circle["energy"])
    assert math.isnan(fed(rows[: at + 5_000]).gained), "nor is it known so soon"
