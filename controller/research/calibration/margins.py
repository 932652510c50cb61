"""Whether the loop stays stable with more gain, and with more dead time: a fit at the edge of stability is no fit.

No margin is a row of the paper, so P2 and P3 are asked as well. Each run ends in a hold, after a step or after a circle
that stops; the laps of the circle show what does not repeat from lap to lap.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from controller.arrays import Array
from controller.reference.reference import Reference
from controller.research.calibration.predictions import BROKEN, attempt
from controller.schema.actuator import PRESETS
from controller.schema.fit import GAIN_NAMES
from controller.schema.modes import Law
from controller.schema.parameters import ControllerParameters, RigParameters
from controller.simulation.case import Setup, planned
from controller.simulation.metrics import rmse, true_tip

Change = Literal["gain", "delay"]
CHANGES: tuple[Change, ...] = ("gain", "delay")
GAIN_FACTOR = 1.5
"""All of K_P, K_I and K_FF times this."""
MORE_DELAY = 0.015
"""Added to the twin's dead time [s]."""
SWING_MAX = 3e-3
"""The oscillation that may be left, rms [m]: 4 % of a step's 79 mm, 5 % of the circle's diameter."""
GROWTH_MAX = 1.1
"""What is left in the last second over what was left in the second before. A steady swing's rms differs by up to a
tenth from one second to the next; a loop that gains as little is at worst neutral, and SWING_MAX still holds."""
FLOOR = 1e-3
"""What is smaller counts as this in the growth [m]: noise and stick-slip do not decay, and are not instability."""
GUARD = 0.9
"""The penalty sets in at this share of both bounds, so that a fit that it holds back still keeps them."""
SCALE = 0.1
"""ln(value / guarded bound) that costs one standard deviation."""
SECOND = 1000
"""Ticks, and the period of the circle."""
LAPS, HOLD = 5, 3
"""Laps of the circle [s], and the hold after it [s]."""


@dataclass(frozen=True)
class Trial:
    """One actuator on one reference ("step", or "stop": a circle, then a hold) with one change of the loop."""

    actuator: str
    reference: Literal["step", "stop"]
    change: Change


@dataclass(frozen=True)
class Margin:
    """What a trial left."""

    trial: Trial
    swing: float
    """Oscillation in the last second of a hold or lap, the worst [m]; nan if the run was broken off."""
    growth: float
    """Last second over the one before, the worst."""
    lasted: float

    @property
    def kept(self) -> bool:
        """Whether the loop was stable."""
        return self.lasted == 1.0 and self.swing <= SWING_MAX and self.growth <= GROWTH_MAX

    @property
    def penalty(self) -> float:
        """Residual: 0 where the margin is kept with room to spare, growing smoothly from there."""
        if self.lasted < 1.0:
            return BROKEN * (2.0 - self.lasted)
        seen = min(max(self.swing / FLOOR - 1.0, 0.0), 1.0)
        swing = max(0.0, math.log(self.swing / (GUARD * SWING_MAX)))
        growth = max(0.0, math.log(self.growth / (GUARD * GROWTH_MAX)))
        return min(math.hypot(swing, seen * growth) / SCALE, BROKEN)


TRIALS = (
    *(Trial("P1", "step", change) for change in CHANGES),
    *(Trial(actuator, "stop", change) for actuator in PRESETS for change in CHANGES),
)
"""All that P2 and P3 are asked is whether the one set of gains is safe for them."""


def measure_margins(trials: Sequence[Trial], setup: Setup, seed: int = 0) -> tuple[Margin, ...]:
    """Every trial on `setup`, under FF+PI."""
    return tuple(measure_margin(trial, setup, seed) for trial in trials)


def measure_margin(trial: Trial, setup: Setup, seed: int) -> Margin:
    """One trial. K_FF is on where the reference has it."""
    harder = strained(setup, trial.change)
    parameters = RigParameters(actuator=PRESETS[trial.actuator], controller=harder.controller, twin=harder.twin)
    path = (stop if trial.reference == "stop" else step)(trial.actuator, setup.controller)
    settings = harder.gains.model_copy(update={"law": Law.FF_PI})
    rows, lasted = attempt(parameters, path, settings, seed)
    if lasted < 1.0:
        return Margin(trial, math.nan, math.nan, lasted)
    swings = left_over(true_tip(rows), path)
    growth = max(max(last, FLOOR) / max(before, FLOOR) for before, last in swings)
    return Margin(trial, max(last for _, last in swings), growth, lasted)


def strained(setup: Setup, change: Change) -> Setup:
    """`setup` with more gain or more dead time."""
    if change == "gain":
        more = {name: tuple(GAIN_FACTOR * gain for gain in getattr(setup.gains, name)) for name in GAIN_NAMES}
        return Setup(setup.twin, setup.controller, setup.gains.model_copy(update=more))
    twin = setup.twin.model_copy(update={"dead_time": setup.twin.dead_time + MORE_DELAY})
    return Setup(twin, setup.controller, setup.gains)


def step(actuator: str, controller: ControllerParameters) -> Reference:
    """The diamond of four steps."""
    return planned("step", actuator, controller)


@lru_cache(maxsize=8)
def stop(actuator: str, controller: ControllerParameters) -> Reference:
    """The 1 Hz circle for LAPS, then a hold at its first point; `steps` holds the tick at which it begins."""
    circle = planned("circle_1hz", actuator, controller)
    end = circle.start + LAPS * SECOND
    p = np.vstack([circle.p[:end], np.tile(circle.p[circle.start], (HOLD * SECOND, 1))])
    return Reference("stop", p, circle.start, (end,), circle.frequency, velocity_feedforward=True, known=True)


def left_over(p: Array, path: Reference) -> list[tuple[float, float]]:
    """Oscillation of the tip p (n,2) [m], rms, in the last second but one and in the last of every hold and circle."""
    ends = (*path.steps[1:], len(p))
    pairs = [(wobble(p[end - 2 * SECOND : end - SECOND]), wobble(p[end - SECOND : end])) for end in ends]
    if path.frequency is not None:
        laps = p[path.start : path.steps[0]].reshape(LAPS, SECOND, 2)
        changed = np.diff(laps, axis=0)
        pairs.append((rmse(changed[-2]), rmse(changed[-1])))
    return pairs


def wobble(p: Array) -> float:
    """What a parabola leaves of p (n,2) [m], rms: the integral's slow way home is no oscillation."""
    t = np.linspace(-1.0, 1.0, len(p))
    return rmse(p - np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyfit(t, p, 2)).T)
