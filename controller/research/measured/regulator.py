"""A pressure regulator of Festo (VEAB): one dead time and one lag for all takes, as the twin's chambers have."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array
from controller.errors import DataError
from controller.research.measured.sets import Answer, MeasuredSet, Question
from controller.simulation.lag import lagged

FOLDER = "Benchmark/OneFesto(125Hz)"
TAKES = [*(f"repeating_take{n}" for n in range(1, 6)), *(f"sweep_take{n}" for n in range(1, 6))]
SECONDS = (20, 40, 40, 40, 40, 15, 20, 20, 20, 20)
FILES = tuple(f"{FOLDER}/{name}_{seconds}s.mat" for name, seconds in zip(TAKES, SECONDS, strict=True))
FITTED = (FILES[0], FILES[5])
"""The first of each kind."""
KPA = 0.1
"""kPa of the hPa in which pressures are."""
FIRST = (20.0, 0.0, 0.035, 0.015)
"""Gain [kPa/V], offset [kPa], dead time [s] and lag [s] from which the fit begins."""
SCALE = (1.0, 1.0, 0.01, 0.01)
WAYS = {"ours": (True, True), "dead time alone": (True, False), "lag alone": (False, True), "neither": (False, False)}
"""Whether there is a dead time, and a lag."""
BY_HAND = {"by hand, each take by itself": 2.26}
"""[kPa]; the best of the takes had 0.76."""


class Take(NamedTuple):
    """One recording."""

    t: Array
    """Even times (n,) [s]."""
    asked: Array
    """(n,) [V]."""
    p: Array
    """Absolute pressure (n,) [kPa]."""


def answers(paths: Mapping[str, Path]) -> list[Answer]:
    """Median and worst rms of the takes that were not fitted [kPa]."""
    takes = {inner: read_take(path) for inner, path in paths.items()}
    fitted, unseen = [takes[one] for one in FITTED], [take for name, take in takes.items() if name not in FITTED]
    off = {name: _rms(unseen, _fitted(fitted, *free)) for name, free in WAYS.items()}
    return [
        Answer(float(of(off["ours"])), {name: float(of(off[name])) for name in list(WAYS)[1:]} | others)
        for of, others in ((np.median, {}), (np.max, BY_HAND))
    ]


def predicted(take: Take, gain: float, offset: float, dead: float, lag: float) -> Array:
    """Pressure (n,) [kPa] of a regulator with these numbers that begins where the take does."""
    asked = gain * np.interp(take.t - dead, take.t, take.asked) + offset
    if lag <= 0.0:
        return asked
    keep = np.exp(-(take.t[1] - take.t[0]) / lag)
    return np.append(take.p[0], lagged(asked[1:], keep, take.p[:1]))


def read_take(path: Path) -> Take:
    """From a MATLAB file of version 7.3 with one time series of asked voltage, measured voltage and pressure [hPa].

    Raises DataError where no such series is in it.
    """
    import h5py  # type: ignore[import-untyped]  # of the extra research; the other sets need it not

    try:
        with h5py.File(path) as file:
            tables = [np.array(one) for one in file["#refs#"].values() if isinstance(one, h5py.Dataset)]
    except (OSError, KeyError) as error:
        raise DataError(f"{path}: no MATLAB file of version 7.3 with a time series: {error}") from error
    times, series = _longest(tables, lambda one: one.shape[0] == 1), _longest(tables, lambda one: one.shape[1] == 3)
    if times is None or series is None or times.size != len(series):
        raise DataError(f"{path}: no time series of three signals")
    return _even(times.ravel(), series)


def _longest(tables: Sequence[Array], fits: Any) -> Array | None:
    numbers = [one for one in tables if one.dtype == float and one.ndim == 2 and one.size > 1 and fits(one)]
    return max(numbers, key=lambda one: one.size, default=None)


def _even(t: Array, series: Array) -> Take:
    """At even times: some takes have samples between the others."""
    step = float(np.median(np.diff(t)))
    even = t[0] + step * np.arange(int((t[-1] - t[0]) / step + 1.5))
    asked, p = (np.interp(even, t, series[:, column]) for column in (0, 2))
    return Take(even, asked, KPA * p)


def _fitted(takes: Sequence[Take], dead: bool, lag: bool) -> Array:
    free = np.array([True, True, dead, lag])

    def numbers(x: Array) -> Array:
        whole = np.where(free, FIRST, 0.0)
        whole[free] = x
        return np.asarray(whole)

    def off(x: Array) -> Array:
        return np.concatenate([predicted(take, *numbers(x)) - take.p for take in takes])

    bounds = np.array([(0.0, np.inf), (-np.inf, np.inf), (0.0, 0.5), (1e-4, 0.5)])[free].T
    return numbers(least_squares(off, np.array(FIRST)[free], x_scale=np.array(SCALE)[free], bounds=bounds).x)


def _rms(takes: Sequence[Take], numbers: Array) -> list[float]:
    return [float(np.sqrt(np.mean((predicted(take, *numbers) - take.p) ** 2))) for take in takes]


QUESTION = "pressure of eight takes, dead time and lag fitted on two others"
REGULATOR = MeasuredSet(
    name="Festo VEAB",
    source="github.com/chukhanhhoang/SoftRoboticSetupFesto at ac8c148",
    licence="none: to judge by, not to pass on",
    files=FILES,
    questions=(Question(QUESTION, "median rms", "kPa"), Question(QUESTION, "worst rms", "kPa")),
    answers=answers,
)
