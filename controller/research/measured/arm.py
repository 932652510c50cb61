"""A hanging arm of four columns of pouches: its tip under their pressures, after a fit to six of 31 conditions.

As the tentacle's, each pose is planar, in the plane of the columns' resultant moment. The base was moved between the
recordings, so each condition's tip counts from its mean.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array, Mask
from controller.assembly.equilibrium import body_of, carrying, settle
from controller.assembly.rod import build_rod
from controller.errors import DataError
from controller.research.measured.sets import Answer, MeasuredSet, Question
from controller.schema.actuator import Actuator
from controller.simulation.lag import lagged

OCTOBER = {"25": (1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 15, 17, 18, 19, 20), "28": (1, 2, *range(5, 16), 18, 19)}
"""Days, and their experiments in the public snapshot that we have seen: some 100 samples a second for two minutes."""
PATH = "experiments/csv/October-{}/cleaned_data/Experiment_{}.csv"
FILES = tuple(PATH.format(day, n) for day, all_n in OCTOBER.items() for n in all_n)
FITTED = tuple(
    PATH.format(day, n) for day, n in (("25", 13), ("25", 17), ("25", 18), ("25", 19), ("28", 10), ("28", 19))
)
"""All columns at once, three of them at two pressures, and one of them alone by two base pressures, on both days."""
WINDOW_S = (40.0, 110.0)
"""Seven cycles, after the pouches were filled and before they are let go [s]."""
EVERY = 10
"""Samples from one that is fitted to the next."""
COLUMNS = tuple(
    tuple(f"Measured_pressure_Segment_{column}_pouch_{pouch}" for pouch in range(1, 6))
    if column <= 2
    else (f"Measured_pressure_Segment_{column}",)
    for column in (1, 2, 3, 4)
)
"""Pressures [psi] of each column, whose mean counts."""
TIP = tuple(f"mocap_rigid_body_{axis}" for axis in "xyz")
"""[m]; y is up."""
LENGTH, MASS, TIP_MASS, TIP_ARM, EI = 0.296, 0.35, 0.08, 0.07, 0.4168 * 0.296 / 5
"""[m], [kg], how far beyond the end the body is that is seen [m], [N m^2]: as given with the data."""
RODS, MOMENTS = 20, np.linspace(0.0, 0.3, 31)
"""And the moments for which the rod is solved [N m]."""
FIRST = np.array([1.5, 1.0, 1.0, 1.0, 1.0, 0.2, 1.0, 1.0, 1.0, 1.0])
"""Direction of the first column about the axis [rad], each column's moment [0.01 N m/psi], lag [s], and by how much
each lengthens the arm [%/psi], from which the fit begins."""
SCALE = np.array([0.1, 0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1])
BY_OTHERS = {"their twin, in 36 later conditions": 1.08}
"""As published with it: 3.03 mm across and 1.07 mm along, of 296."""


class Condition(NamedTuple):
    """One recording."""

    t: Array
    """(n,) [s]."""
    p: Array
    """Pressures (4,n) [psi]."""
    tip: Array
    """(3,n) [m], nan where it is not seen."""


def answers(paths: Mapping[str, Path]) -> list[Answer]:
    """Rms distance of the tip's motion in the conditions that were not fitted, in percent of the length."""
    read = {inner: read_condition(path) for inner, path in paths.items()}
    fitted, unseen = [read[one] for one in FITTED], [one for inner, one in read.items() if inner not in FITTED]
    rod = _fitted(fitted)
    pressures, tips = (np.hstack(parts) for parts in zip(*map(_motions, fitted), strict=True))
    linear, *_ = np.linalg.lstsq(pressures.T, tips.T)
    off = {
        "ours": [predicted(one, rod) - _motion(one.tip, one) for one in unseen],
        "a linear map of the pressures": [linear.T @ p - tip for p, tip in map(_motions, unseen)],
        "no motion": [_motion(one.tip, one) for one in unseen],
    }
    percent = {name: _percent(each) for name, each in off.items()}
    return [Answer(percent.pop("ours"), percent | BY_OTHERS)]


def read_condition(path: Path) -> Condition:
    """The recording in the file; DataError where it is none."""
    try:
        with path.open(encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            wanted = ["time", *(name for column in COLUMNS for name in column), *TIP]
            rows = np.loadtxt(file, delimiter=",", usecols=[names.index(name) for name in wanted], ndmin=2)
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: no table with time, measured pressures and mocap_rigid_body: {error}") from error
    ends = np.cumsum([1, *map(len, COLUMNS)])
    p = np.array([rows[:, first:last].mean(axis=1) for first, last in pairwise(ends)])
    tip = np.where((rows[:, -3:] == 0.0).all(axis=1)[:, None], np.nan, rows[:, -3:]).T
    found = Condition(rows[:, 0], p, tip)
    if _counts(found).sum() < 2 * EVERY:
        raise DataError(f"{path}: the tip is hardly seen from {WINDOW_S[0]:g} to {WINDOW_S[1]:g} s")
    return found


def predicted(one: Condition, numbers: Array) -> Array:
    """Motion (3,m) [m] of the tip in the window, of an arm with these `numbers`, as FIRST."""
    keep = np.exp(-np.median(np.diff(one.t)) / max(numbers[5], 1e-6))
    p = lagged(one.p, keep, one.p[:, :1])
    angles = numbers[0] - np.pi / 2 * np.arange(4)
    moment = (0.01 * numbers[1:5] * np.array([np.cos(angles), np.sin(angles)])) @ p
    return _motion(_tip(moment, 0.01 * numbers[6:] @ p), one)


def _tip(moment: Array, strain: Array) -> Array:
    """Places (3,n) [m] under moments (2,n) [N m] about the horizontal axes, of an arm longer by a share (n,)."""
    size = np.hypot(*moment)
    across, down, angle = (np.interp(size, MOMENTS, each) for each in _poses())
    way = moment / np.maximum(size, 1e-9)
    across, down = (across, down) * (1.0 + strain) + TIP_ARM * np.array([np.sin(angle), np.cos(angle)])
    return np.array([way[0] * across, -down, way[1] * across])


@cache
def _poses() -> Array:
    """End (across, down) [m] and its angle [rad] for each of MOMENTS: (3,n)."""
    actuator = Actuator.model_validate(
        {
            "name": "soft arm",
            "mass": MASS,
            "tip_load": TIP_MASS,
            "length": LENGTH,
            "table_rods": RODS,
            "EI": [EI, EI],
            "EI_arc": [0.0, LENGTH],
            "beta": 1e-3,
            "gravity": (9.81, 0.0),
        }
    )
    model, at_end = build_rod(actuator, RODS), np.eye(RODS)[-1]
    theta = np.array([settle(carrying(body_of(model), size * at_end), model.rest) for size in MOMENTS])
    ends = LENGTH / RODS * np.array([np.sin(theta).sum(axis=1), np.cos(theta).sum(axis=1)])
    return np.vstack([ends, theta[:, -1]])


def _fitted(conditions: Sequence[Condition]) -> Array:
    def off(x: Array) -> Array:
        each = [(predicted(one, FIRST + x * SCALE) - _motion(one.tip, one))[:, ::EVERY] for one in conditions]
        return np.hstack(each).ravel()

    return np.asarray(FIRST + least_squares(off, np.zeros(FIRST.size), method="lm").x * SCALE)


def _counts(one: Condition) -> Mask:
    """Which samples (n,) are in the window, with the tip in sight."""
    return (one.t > WINDOW_S[0]) & (one.t < WINDOW_S[1]) & np.isfinite(one.tip).all(axis=0)


def _motion(course: Array, one: Condition) -> Array:
    """Of a course (k,n), what counts of it (k,m), from its mean."""
    counted = course[:, _counts(one)]
    return np.asarray(counted - counted.mean(axis=1, keepdims=True))


def _motions(one: Condition) -> tuple[Array, Array]:
    return _motion(one.p, one), _motion(one.tip, one)


def _percent(each: Sequence[Array]) -> float:
    """Root of the mean over the conditions, each of which counts alike."""
    return float(100.0 / LENGTH * np.sqrt(np.mean([np.mean((off**2).sum(axis=0)) for off in each])))


ARM = MeasuredSet(
    name="soft arm",
    source="github.com/Jeevan-HM/Soft-Robotic-Arm",
    licence="MIT",
    files=FILES,
    questions=(Question("the tip's motion in 25 conditions, after a fit to six", "rms distance", "% of length"),),
    answers=answers,
)
