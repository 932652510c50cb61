"""Dead time and lag from steps: found in made-up data with noise and quantisation, and in the twin's valves."""

import math
from functools import cache

import numpy as np
import pytest

from controller.errors import ParameterError
from controller.schema.parameters import TwinParameters
from controller.simulation.pneumatic_fit import ChamberSteps, fit_pneumatics
from tests.controller.kernels.plant.test_valve import run

pytestmark = pytest.mark.keyed()

DT = 1e-3
LEVELS = (60e3, 20e3, 45e3, 0.0)


def asked(repeats: int = 2, hold: int = 700) -> tuple[np.ndarray, tuple[int, ...]]:
    """Setpoints (n,) [Pa] that rise and fall at 2 MPa/s, and where each step begins."""
    steps = [0.0, *LEVELS * repeats]
    wanted = np.repeat(steps, [200, *[hold] * (len(steps) - 1)])
    ramped = np.empty_like(wanted)
    at = 0.0
    for row, level in enumerate(wanted):
        at += np.clip(level - at, -2e3, 2e3)
        ramped[row] = at
    return ramped, tuple(range(200, len(wanted), hold))


@cache
def stepped_finely(dead_time: float, inflate: float, exhaust: float, substeps: int = 10) -> np.ndarray:
    """The same model, by another scheme: midpoints of fine steps, the delay by whole ones."""
    fine = np.repeat(asked()[0], substeps)
    late = np.concatenate((np.zeros(round(dead_time / DT * substeps)), fine))[: len(fine)]
    p, course = 0.0, []
    for level in late.tolist():
        share = DT / substeps / (inflate if level > p else exhaust)
        p += share * (level - (p + 0.5 * share * (level - p)))
        course.append(p)
    return np.array(course)[::substeps]


def measured(p: np.ndarray, seed: int, noise: float = 300.0, bit: float = 250.0, every: int = 2) -> np.ndarray:
    """`p` (n,) [Pa] as a sensor shows it: noisy, in steps of `bit`, read every so many rows and held."""
    read = p[::every] + np.random.default_rng(seed).normal(0.0, noise, len(p[::every]))
    return np.repeat(np.round(read / bit) * bit, every)[: len(p)]


def chamber(seed: int, dead_time: float, inflate: float, exhaust: float, **sensor: float) -> ChamberSteps:
    wanted, starts = asked()
    return ChamberSteps(wanted, measured(stepped_finely(dead_time, inflate, exhaust), seed, **sensor), starts)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "dead_time, inflate, exhaust", [(0.05, 0.05, 0.05), (0.012, 0.03, 0.06), (0.08, 0.15, 0.1), (0.0, 0.02, 0.02)]
)
def test_dead_time_and_lags_come_back_from_noisy_quantised_held_readings(
    dead_time: float, inflate: float, exhaust: float
) -> None:
    found = fit_pneumatics([chamber(seed, dead_time, inflate, exhaust) for seed in range(4)], DT)
    assert found.inflate.value == pytest.approx(inflate, rel=0.03)
    assert found.exhaust.value == pytest.approx(exhaust, rel=0.03)
    assert found.gains == pytest.approx([1.0] * 4, abs=0.02)
    if inflate == exhaust:
        assert found.lag.value == pytest.approx(inflate, rel=0.03)
        assert found.dead_time.value == pytest.approx(dead_time + 0.5e-3, abs=1.5e-3)  # readings are 0.5 ms old
        assert found.residual < 400.0
    else:
        assert min(inflate, exhaust) < found.lag.value < max(inflate, exhaust)


def test_the_intervals_hold_the_truth_of_most_data() -> None:
    held = 0
    for seed in range(12):
        found = fit_pneumatics([chamber(10 * seed + one, 0.04, 0.06, 0.06, every=1) for one in range(4)], DT)
        held += found.lag.low <= 0.06 <= found.lag.high
        assert found.lag.high - found.lag.low < 0.01
    assert held >= 10


def test_outliers_hardly_count_and_missing_readings_do_not() -> None:
    broken = []
    for seed in range(4):
        one = chamber(seed, 0.04, 0.06, 0.06)
        shown = one.shown.copy()
        shown[50::97] += 60e3
        shown[1000:1100] = math.nan
        broken.append(one._replace(shown=shown))
    found = fit_pneumatics(broken, DT)
    assert found.lag.value == pytest.approx(0.06, rel=0.05)
    assert found.dead_time.value == pytest.approx(0.0405, abs=3e-3)


def test_the_twins_valves_are_as_slow_as_they_were_tuned() -> None:
    twin = TwinParameters()
    wanted, starts = asked()
    found = fit_pneumatics([ChamberSteps(wanted, run(twin, wanted)[0][:, 0], starts)] * 2, DT)
    assert found.dead_time.value == pytest.approx(twin.dead_time, abs=0.012)
    assert found.lag.value == pytest.approx((twin.inflate_time + twin.exhaust_time) / 2, rel=0.3)
    assert found.residual < 0.05 * 60e3
    later = TwinParameters(dead_time=0.09)
    moved = fit_pneumatics([ChamberSteps(wanted, run(later, wanted)[0][:, 0], starts)] * 2, DT)
    assert moved.dead_time.value - found.dead_time.value == pytest.approx(0.04, abs=1e-3)
    assert moved.lag.value == pytest.approx(found.lag.value, rel=0.02)


@pytest.mark.parametrize(
    "change, complaint",
    [
        (lambda one: one._replace(shown=np.zeros_like(one.shown)), "its pressure moved by 0 Pa when 60000 Pa"),
        (lambda one: one._replace(asked=one.asked * 0.01), "chamber 1: its setpoint moved by 600 Pa, at least 5000 Pa"),
        (lambda one: one._replace(starts=one.starts[:3]), "3 steps of pressure: at least 4"),
    ],
)
def test_what_steps_cannot_tell_is_refused_by_number_and_bound(change: object, complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        fit_pneumatics([change(chamber(0, 0.04, 0.06, 0.06))], DT)  # type: ignore[operator]


def test_valves_too_slow_for_the_controller_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"dead time = 0.2 s: the controller takes 0.2 s"):
        fit_pneumatics([chamber(0, 0.26, 0.06, 0.06)], DT)
