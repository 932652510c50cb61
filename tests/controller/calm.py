"""Runs that the watchdogs of the feedback must not stop: drags of every kind, sensors, and the markers' own faults."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from controller.arrays import Rows
from controller.drivers.twin import inject
from controller.schema.fit import GAINS
from controller.schema.messages import TwinFaults
from controller.schema.parameters import SafetyLimits
from tests.controller.trial import Trial
from tests.controller.whips import Gains, parameters

CENTRE = np.array([0.03, 0.14])
QUICK: dict[str, Any] = {"speed_max": 1.0, "acceleration_max": 10.0}
"""The page's bounds."""
REACH = (-0.1, 0.25), (-0.22, 0.22)
KINDS = ("random", "walk", "sine 0.5", "sine 1", "sine 2", "square 0.5", "square 1", "square 2", "square 4")
SENSED = {"rod 6": 1 << 5, "rod 10": 1 << 9, "rods 6 and 10": 1 << 5 | 1 << 9, "all": 1023}
FAULTS = (TwinFaults(noise=2e-3), TwinFaults(sample_loss=0.3), TwinFaults(marker_loss=0.3))


class Drag(NamedTuple):
    """How a target is dragged, on what."""

    kind: str
    actuator: str
    seed: int
    faults: TwinFaults = TwinFaults()
    settings: tuple[tuple[str, Any], ...] = ()


def drag(how: Drag, limits: SafetyLimits) -> Rows:
    """Telemetry of the whole drag, with the gains as they are at the start but for `how.settings`."""
    random = np.random.default_rng(how.seed)
    standard = Gains(how.actuator, GAINS["K_P"], GAINS["K_I"], seed=how.seed)
    trial = Trial(parameters=parameters(standard, limits), **dict(how.settings))
    inject(how.faults, trial.twin.faults)
    rows = [trial.arm(), trial.follow(*CENTRE, 3.0)]
    rows += [trial.drag([tuple(p) for p in path], seconds) for path, seconds in paths(how.kind, random)]
    return np.concatenate(rows)


def paths(kind: str, random: np.random.Generator) -> Iterator[tuple[np.ndarray, float]]:
    """Points (n, 2) [m] that the pointer takes one after the other, evenly in that time."""
    name, _, number = kind.partition(" ")
    t, away = np.arange(0.0, 5.0, 0.01), random.normal(size=2)
    away /= np.linalg.norm(away)
    if name == "random":
        for _ in range(12):
            yield np.array([[random.uniform(*side) for side in REACH]]), random.choice([0.2, 0.5, 1.0, 2.0])
    elif name == "walk":
        walk = CENTRE + np.cumsum(random.normal(0.0, 0.01, (800, 2)), axis=0)
        yield np.clip(walk, *np.transpose(REACH)), 16.0
    else:
        wave = np.sin(2 * np.pi * float(number) * t + 1e-9)
        for amplitude in (0.01, 0.03, 0.06):
            yield CENTRE + amplitude * away * (np.sign(wave) if name == "square" else wave)[:, None], 5.0


def drags(seeds: range) -> Iterator[Drag]:
    """All kinds on all actuators with all sensors, and with markers that are noisy or often not seen."""
    for seed in seeds:
        for actuator in ("P1", "P2", "P3"):
            for kind in KINDS:
                yield Drag(kind, actuator, seed)
            for sensed in SENSED.values():
                yield Drag("random", actuator, seed, settings=(("sensed", sensed),))
            for faults in FAULTS:
                yield Drag("walk", actuator, seed, faults)


def quick_drags(seeds: range) -> Iterator[Drag]:
    """The same at the highest speed and acceleration that the page allows; some make the arm whip."""
    for one in drags(seeds):
        yield one._replace(settings=(*one.settings, *QUICK.items()))
