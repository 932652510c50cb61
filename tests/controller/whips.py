"""Runs in which gains make the arm whip, and runs in which it must not be thought to: what the watchdogs do in each.

A run is made twice, with the watchdogs of the feedback and without: up to their reaction both are the same to the bit,
so the free one says when the whip began.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.signal import butter, sosfiltfilt

from controller.arrays import Rows
from controller.schema.actuator import PRESETS
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, Settings, TwinParameters
from controller.simulation.case import planned
from controller.simulation.run import attempt
from tests.controller.trial import Trial, true_tip

FREE = SafetyLimits(
    error_time=60.0, speed_max=100.0, pressure_off_time=10.0, error_rms_max=1.0, swing_max=1.0, residual_max=1.0
)
"""No watchdog minds a whip."""
NAMED = (Cause.OSCILLATION, Cause.TRACKING_RMS)
LIVE = (Mode.HOLD, Mode.FOLLOW, Mode.TRACK)
WHIP, LASTS = 0.05, 500
"""Amplitude [m], and for how many ticks it lasts, from which on a swing of the tip is a whip."""
BAND = butter(2, [1.5, 12.0], "band", fs=1000.0, output="sos")


class Gains(NamedTuple):
    """A choice that the page allows."""

    actuator: str
    K_P: float
    K_I: float
    K_FF: float = 0.0
    seed: int = 0
    others: tuple[tuple[str, Any], ...] = ()

    @property
    def settings(self) -> dict[str, Any]:
        pair = {name: (getattr(self, name),) * 2 for name in ("K_P", "K_I", "K_FF")}
        return pair | dict(self.others)


Run = Callable[[Gains, SafetyLimits], Rows]


def parameters(gains: Gains, limits: SafetyLimits) -> RigParameters:
    return RigParameters(actuator=PRESETS[gains.actuator], limits=limits, twin=TwinParameters(seed=gains.seed))


def held(gains: Gains, limits: SafetyLimits) -> Rows:
    """The gains are changed while the arm is held at a bent pose."""
    trial, side = Trial(parameters=parameters(gains, limits)), 1 - 2 * (gains.seed % 2)
    trial.arm()
    trial.follow(0.03, side * 0.13, 3.0)
    trial.ask(Request.HOLD, ticks=500)
    trial.switch(**gains.settings)
    return trial.run(6000)


def followed(gains: Gains, limits: SafetyLimits) -> Rows:
    """Targets anywhere, five of them, at the speed that a page begins with."""
    random = np.random.default_rng(gains.seed)
    trial = Trial(parameters=parameters(gains, limits), **gains.settings)
    goals = zip(random.uniform(-0.1, 0.25, 5), random.uniform(-0.22, 0.22, 5), strict=True)
    return np.concatenate([trial.arm(), *(trial.follow(x, y, 1.6) for x, y in goals)])


def tracked(gains: Gains, limits: SafetyLimits) -> Rows:
    """The paper's circle."""
    circle = planned("circle_1hz", gains.actuator, ControllerParameters())
    return attempt(parameters(gains, limits), circle, Settings(**gains.settings), gains.seed)


RUNS: dict[str, Run] = {"HOLD": held, "FOLLOW": followed, "TRACK": tracked}


class Judged(NamedTuple):
    """What came of a run; ticks of the run, None: never."""

    onset: int | None
    reaction: int | None
    mode: Mode
    cause: Cause
    worst: float
    """Largest error before the reaction [m]."""


def judged(run: Run, gains: Gains) -> Judged:
    """`run` with `gains`: when the whip began, and what the watchdogs made of it."""
    rows = run(gains, SafetyLimits())
    mode, cause, reaction = Mode.HOLD, Cause.NONE, broken(rows)
    if reaction is not None:
        mode, cause = Mode(rows["mode"][reaction]), Cause(rows["cause"][reaction])
    worst = float(np.hypot(*rows["error"][:reaction].T).max(initial=0.0))
    return Judged(onset(run(gains, FREE)), reaction, mode, cause, worst)


def broken(rows: Rows) -> int | None:
    """The tick at which the rig left the modes in which it is operated, by itself."""
    live = np.isin(rows["mode"], LIVE)
    ended = np.flatnonzero(live[:-1] & ~live[1:])
    return int(ended[0]) + 1 if ended.size else None


def onset(rows: Rows) -> int | None:
    """The tick from which on the true tip swings by WHIP, three times as far as its reference, for LASTS ticks.

    Or for as long as another watchdog lets it.
    """
    live = np.isin(rows["mode"], LIVE)
    tip, reference = swing(true_tip(rows), 300), swing(rows["p_ref"], 800)
    whips = (tip > WHIP) & (tip > 3.0 * reference) & live
    count = np.cumsum(np.append(0, whips | ~live))
    begins = np.flatnonzero(whips[: 1 - LASTS] & (count[LASTS:] - count[:-LASTS] == LASTS))
    return int(begins[0]) + 150 if begins.size else None


def swing(p: np.ndarray, ticks: int) -> np.ndarray:
    """Amplitude (n,) [m] of what of p (n,2) is neither slow nor noise: its envelope, `ticks` wide."""
    band = sosfiltfilt(BAND, np.nan_to_num(p), axis=0)
    return np.asarray(maximum_filter1d(np.hypot(*band.T), ticks))
