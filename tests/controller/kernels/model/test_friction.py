"""Friction that sticks: Dahl's loop against its closed form, on the sheet and in the hinges."""

import math
from typing import Any

import numpy as np
import pytest

from controller.assembly.twin import build_twin
from controller.kernels.model.friction import resist_hysteresis, rub
from controller.schema.parameters import RigParameters, TwinParameters
from tests.controller.chains import compiled
from tests.controller.kernels.plant.test_twin import IDEAL, held, run, twin_of

pytestmark = pytest.mark.keyed()

WEIGHT = 9.81


def twin_with(**flaws: Any) -> Any:
    return build_twin(RigParameters(twin=TwinParameters(**IDEAL | flaws)))


@compiled
def drags(twin: Any, v: np.ndarray, h: float, forces: np.ndarray) -> None:
    """Friction on the first rod for the velocities v (n,2) [m/s], each for h [s]."""
    for i in range(v.shape[0]):
        twin.state.v[0, 0], twin.state.v[1, 0] = v[i, 0], v[i, 1]
        rub(twin.model.m, twin.state.v, h, twin.sheet, twin.load.F)
        forces[i] = twin.load.F[:, 0]


@compiled
def torques(twin: Any, bends: np.ndarray, found: np.ndarray) -> None:
    """Torque of the slider in the last hinge over the bends (n,) [rad]."""
    for i in range(bends.size):
        twin.state.q[2, -1] = twin.state.q[2, -2] + bends[i]
        twin.load.Q_theta[:] = 0.0
        resist_hysteresis(twin.model, twin.state.q, twin.hysteresis, twin.load.Q_theta)
        found[i] = twin.load.Q_theta[-1]


def test_friction_builds_up_over_the_slip_and_ends_at_coulombs_bound_at_any_speed() -> None:
    for speed in (1e-4, 0.1):
        twin = twin_with(friction=0.2, slip=1e-3)
        found = np.zeros((2000, 2))
        drags(twin, np.tile([0.6 * speed, -0.8 * speed], (2000, 1)), 5e-6 / speed, found)
        bound = 0.2 * twin.model.m[0] * WEIGHT
        way = 5e-6 * np.arange(1, 2001)
        expected = -bound * (1.0 - np.exp(-way / 1e-3))[:, None] * [0.6, -0.8]
        assert found == pytest.approx(expected, rel=1e-9)


def test_friction_never_exceeds_its_bound_whatever_the_motion() -> None:
    twin = twin_with(friction=0.3, slip=2e-4)
    found = np.zeros((5000, 2))
    drags(twin, np.random.default_rng(2).normal(0.0, 0.3, (5000, 2)), 1e-3, found)
    assert np.linalg.norm(found, axis=1).max() <= 0.3 * twin.model.m[0] * WEIGHT * (1 + 1e-12)


def test_a_closed_loop_of_bending_costs_what_dahls_law_says() -> None:
    """Between bends +-B the torque is +-tanh(B / bend) of its bound at the turns, and the area is in closed form."""
    twin = twin_with(hysteresis=0.3, hysteresis_bend=0.14)
    k, bend, B = twin.model.k[-1], twin.hysteresis.bend, 0.05
    down, up = np.linspace(B, -B, 20_001), np.linspace(-B, B, 20_001)
    loops = np.concatenate([np.linspace(0.0, B, 20_001), *(np.concatenate([down, up]) for _ in range(30))])
    found = np.zeros(loops.size)
    torques(twin, loops, found)
    last, moved = found[-40_002:], loops[-40_002:]
    greatest = 0.3 * k * bend
    assert last[-1] == pytest.approx(-greatest * math.tanh(B / bend), rel=1e-6)
    area = -float(np.sum(0.5 * (last[1:] + last[:-1]) * np.diff(moved)))
    assert area == pytest.approx(4.0 * greatest * (B - bend * math.tanh(B / bend)), rel=1e-3)


def test_a_stuck_tip_stays_for_ever_and_short_of_the_static_pose() -> None:
    """The same torque, come up to from below and down to from above, leaves the tip in two places that do not drift."""
    flaws = IDEAL | {"friction": 0.3, "zeta": 0.5}
    ends = []
    for first in (30e3, 90e3):
        twin = twin_of(rods=10, **flaws)
        run(twin, held((first, 0.0, 0.0, 0.0), 4.0))
        tip = run(twin, held((60e3, 0.0, 0.0, 0.0), 6.0))[0]["twin_backbone"][:, -1]
        assert np.linalg.norm(tip[-1] - tip[-3000]) < 2e-5
        ends.append(tip[-1])
    assert np.linalg.norm(ends[0] - ends[1]) > 3e-3
