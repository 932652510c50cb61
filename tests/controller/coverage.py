"""How often each "95 %" interval of the product holds a truth that is known.

`python -m tests.controller.coverage [TIMES]` prints it for everything that has one, 200 times each; some ten minutes of
a core. Data are ideal: what the model says, and noise. What is wrong with a model no interval of its own can know.
"""

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from controller.arrays import Array
from controller.research.identification.motion.damping import log_decrement
from controller.research.identification.poses import Poses, predict
from controller.research.identification.static_form import MEANT
from controller.research.identification.statics import fit_statics
from controller.schema.actuator import PRESETS, Actuator
from controller.simulation.first_mode import first_mode
from controller.simulation.pneumatic_fit import ChamberSteps, fit_pneumatics
from tests.controller.simulation.test_first_mode import STRAIGHT, known
from tests.controller.simulation.test_pneumatic_fit import asked, measured, stepped_finely

TIMES = 200
DT, NOISE = 1e-3, 2e-4
ZETA, FREQUENCY = 0.07, 3.2358
RATES = ((0.01, 1e-4, 0.010), (0.01, 1e-5, 0.010), (0.0025, 2e-4, 0.03), (0.02, 2e-4, 0.03))
"""Between samples [s], noise and swing [m]."""


class Estimated(Protocol):
    """A number with its interval."""

    @property
    def value(self) -> float: ...
    @property
    def low(self) -> float: ...
    @property
    def high(self) -> float: ...


class Coverage(NamedTuple):
    """Of one number under one kind of data."""

    name: str
    held: float
    """Share of the intervals that hold the truth."""
    bias: float
    """Mean of the values over the truth, less 1."""


def swung(rate: tuple[float, float, float], draw: np.random.Generator, zeta: float = ZETA) -> tuple[Array, Array]:
    """An arm let go at rest, as a camera sees it."""
    (dt, noise, swing), omega = rate, math.tau * FREQUENCY
    t, damped = np.arange(0.0, 4.0, dt), omega * math.sqrt(1 - zeta**2)
    free = np.exp(-zeta * omega * t) * (np.cos(damped * t) + zeta / math.sqrt(1 - zeta**2) * np.sin(damped * t))
    return t, draw.uniform(0.6, 1.2) * swing * free + draw.normal(0.0, noise, t.size)


def counted(name: str, truths: dict[str, float], found: Iterable[dict[str, Estimated]]) -> Iterator[Coverage]:
    """For each of `truths` how often it was held."""
    every = list(found)
    for what, truth in truths.items():
        held = [one[what].low <= truth <= one[what].high for one in every]
        yield Coverage(
            f"{what}, {name}", float(np.mean(held)), float(np.mean([one[what].value for one in every])) / truth - 1.0
        )


def decays(count: int, rate: tuple[float, float, float], times: int) -> Iterator[Coverage]:
    """Damping ratio and frequency of `count` free decays."""

    def once(seed: int) -> dict[str, Estimated]:
        found = log_decrement([swung(rate, np.random.default_rng((seed, k))) for k in range(count)])
        return {"zeta": found.zeta, "damped frequency": found.omega_d}

    truths = {"zeta": ZETA, "damped frequency": math.tau * FREQUENCY * math.sqrt(1 - ZETA**2)}
    yield from counted(f"{count} decays, {rate[0]:g} s, {1e3 * rate[1]:g} mm", truths, map(once, range(times)))


def pressed(truth: Actuator, count: int, seed: int) -> Poses:
    """Poses of `truth` under four chambers' pressures, two markers each, seen with noise."""
    draw = np.random.default_rng(seed)
    p = draw.uniform(0.0, 0.9 * truth.pressure_max / 2.0, (count, 4))
    arcs = truth.length * np.array([0.5, 1.0])
    given = Poses(
        Path("made.csv"),
        np.arange(2.0, count + 2),
        p,
        True,
        np.zeros((count, 2, 2)),
        arcs,
    )
    points = predict(truth, given)
    return replace(given, points=points + draw.normal(0.0, NOISE, points.shape))


def statics(name: str, truth: Actuator, numbers: dict[str, float], poses: int, times: int) -> Iterator[Coverage]:
    """What static poses tell of `truth`, under the names of the fit."""

    def once(seed: int) -> dict[str, Estimated]:
        shape = "linear" if len(truth.EI or truth.k) == 2 else "uniform"
        told = {"stiffening": (0.0, 0.0), "stretching": (0.0, 0.0), "pressure_map": P1.pressure_map}
        base = truth.model_copy(update=told)
        fit = fit_statics(pressed(truth, poses, seed), base, shape)
        return {one.name: one for one in fit.parameters}

    yield from counted(f"{name}, {poses} poses", numbers, map(once, range(times)))


def swings(repeats: int, noise: float, times: int) -> Iterator[Coverage]:
    """First mode by steps there and back."""
    truths = {"frequency": 3.0, "zeta": 0.2, "kappa": (math.tau * 3.0 / STRAIGHT.omega) ** 2}

    def once(seed: int) -> dict[str, Estimated]:
        found = first_mode(known(0.2, 3.0, noise, repeats=repeats, seed=seed), STRAIGHT)
        return {name: getattr(found, name) for name in truths}

    yield from counted(f"first mode, {repeats} repeats, {1e3 * noise:g} mm", truths, map(once, range(times)))


def pneumatics(noise: float, times: int) -> Iterator[Coverage]:
    """Dead time and lag by steps of four chambers."""
    # a row shows what was measured before its own setpoint went out: a tick less the first tenth of `stepped_finely`
    truths, (wanted, starts) = {"dead_time": 0.0409, "lag": 0.06}, asked()

    def once(seed: int) -> dict[str, Estimated]:
        shown = stepped_finely(0.04, 0.06, 0.06)
        chambers = [
            ChamberSteps(wanted, measured(shown, 10 * seed + one, noise=noise, every=1), starts) for one in range(4)
        ]
        found = fit_pneumatics(chambers, DT)
        return {name: getattr(found, name) for name in truths}

    yield from counted(f"{noise:g} Pa", truths, map(once, range(times)))


P1 = PRESETS["P1"]
TAPERED = P1.model_copy(update={"k": (0.070, 0.030)})
STIFFENED = P1.model_copy(update={"stiffening": (1.24e-6, 0.8e-6)})
KP = {"k": P1.k[0], "stiffening of pair 1": 1.24e-6, "stiffening of pair 2": 0.8e-6}
STRETCHED = STIFFENED.model_copy(update={"stretching": (2.1e-7, 1.5e-7)})
LP = {**KP, "stretching of pair 1": 2.1e-7, "stretching of pair 2": 1.5e-7}
RATIOS = {"u1- over u1+": 1.1, "u2- over u2+": 0.92, "pair 2 over pair 1": 1.06}
GAINS = {"k": P1.k[0]} | {f"pressure for the same torque, {name}": ratio for name, ratio in RATIOS.items()}
UNEVEN = P1.model_copy(
    update={
        "pressure_map": tuple((P1.chamber_slopes * np.exp(MEANT @ np.log(list(RATIOS.values())))).tolist()),
        "u_max": 0.055,
    }
)
RIGID = Actuator.model_validate({"name": "rigid", "mass": 0.1, "length": 0.253, "EI": [2e-3], "beta": 1e-3})
ALL: tuple[Callable[[int], Iterator[Coverage]], ...] = (
    *(lambda times, n=n, rate=rate: decays(n, rate, times) for n in (3, 8, 20) for rate in RATES),
    *(lambda times, n=n: statics("k", P1, {"k": P1.k[0]}, n, times) for n in (4, 16)),
    lambda times: statics("taper", TAPERED, {"k, base joint": 0.070, "k, tip joint": 0.030}, 8, times),
    *(lambda times, n=n: statics("k(p)", STIFFENED, KP, n, times) for n in (12, 45)),
    *(lambda times, n=n: statics("k(p) and L(p)", STRETCHED, LP, n, times) for n in (12, 45)),
    *(lambda times, n=n: statics("gains", UNEVEN, GAINS, n, times) for n in (12, 45)),
    lambda times: statics("EI", RIGID, {"EI": 2e-3}, 8, times),
    *(lambda times, n=n, noise=noise: swings(n, noise, times) for n in (2, 3, 6) for noise in (1e-4, 1e-3)),
    *(lambda times, noise=noise: pneumatics(noise, times) for noise in (100.0, 300.0, 1000.0)),
)


def main() -> None:
    """Print the figures."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else TIMES
    for one in ALL:
        for found in one(times):
            print(f"{100 * found.held:5.1f} %  bias {100 * found.bias:+.2f} %  {found.name}", flush=True)


if __name__ == "__main__":
    main()
