"""Damping of an actuator from free decays of one tracked body: zeta, and the Rayleigh damping that has it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.assembly.stability import undamped
from controller.research.identification.fit import Estimate, Fit, Misfit
from controller.research.identification.motion.damping import Decrement, log_decrement
from controller.research.identification.motion.rayleigh import Rayleigh, rayleigh
from controller.research.identification.motion.swings import Interval
from controller.research.identification.report.damping_plots import (
    amplitudes_plot,
    decays_plot,
    neighbours,
    peaks_plot,
    ratios_plot,
)
from controller.schema.actuator import Actuator

REST_SAMPLES = 20
"""The rest is the mean of a decay's last samples, as many as this."""

APART = 0.1
"""First modes of data and model that differ by more than this share are reported."""

CURVED = 0.1
"""Scatter of ln(peak) beyond the noise from which on the damping is called dependent on amplitude."""

MILLI = 1e3


Signal = tuple[Array, Array]
"""t (n,) [s] and displacement from rest (n,) [m]."""


class FreeDecay(NamedTuple):
    """A free decay of one tracked body."""

    label: str
    t: Array
    """(n,) [s]."""
    points: Array
    """(n,2) or (n,3) [m]."""


def fit_damping(motions: Sequence[FreeDecay], base: Actuator) -> Fit:
    """Damping ratio and frequency of the dominant mode, and alpha and b = beta k of `base` that give the model's first
    mode that ratio.

    The band of interest is from the model's first to its second mode; between them the ratio is lower.
    """
    decays, found = _decrement(motions)
    measured, damped = _described(motions, decays, found, base), _damped(found.zeta.value, base)
    return replace(
        measured,
        method=f"{measured.method} {damped.said}",
        actuator=damped.actuator,
        parameters=(*measured.parameters, *_rayleigh(found.zeta, damped)),
        plots=(*measured.plots, ratios_plot(found, damped.band, *damped.modes)),
        notes=(*_time_scale(found, damped.modes[0]), *measured.notes),
    )


def given_damping(zeta: float, base: Actuator) -> Fit:
    """alpha and b = beta k of `base` for a ratio of the first mode that was measured otherwise, as `fit_damping`."""
    damped, exact = _damped(zeta, base), Interval(zeta, zeta, zeta)
    ratio = Estimate("zeta", zeta, zeta, zeta, "1", "given")
    return Fit(
        title="Damping as given",
        method=f"The damping ratio of the first mode was measured otherwise. {damped.said}",
        actuator=damped.actuator,
        parameters=(ratio, *_rayleigh(exact, damped)),
    )


class _Damped(NamedTuple):
    """An actuator with Rayleigh damping about its first two modes."""

    actuator: Actuator
    band: Rayleigh
    modes: tuple[float, float]
    """[rad/s]."""

    @property
    def said(self) -> str:
        """For the report."""
        first, second = (omega / math.tau for omega in self.modes)
        return f"(alpha, beta) give this ratio to the model's first two modes, {first:.3g} and {second:.3g} Hz."


def _damped(zeta: float, base: Actuator) -> _Damped:
    modes = model_modes(base)
    band = rayleigh(zeta, *modes)
    beta = {} if base.EI is None else {"beta": band.beta}
    changes = {"alpha": band.alpha, "b": tuple(band.beta * k for k in base.k), **beta}
    return _Damped(base.model_copy(update=changes), band, modes)


def _described(motions: Sequence[FreeDecay], decays: Sequence[Signal], found: Decrement, base: Actuator) -> Fit:
    return Fit(
        title="Damping from free decays",
        method=(
            f"Logarithmic decrement of the peaks of {len(motions)} free decays, one line ln(peak) over half periods "
            "each with a common slope."
        ),
        actuator=base,
        parameters=_measured(found),
        misfits=(Misfit("ln(peak), beyond the noise", found.log_misfit, "1", sum(one.s.size for one in found.peaks)),),
        plots=(decays_plot([one.label for one in motions], decays), peaks_plot(found), amplitudes_plot(found)),
        notes=_amplitude_note(found),
    )


def _decrement(motions: Sequence[FreeDecay]) -> tuple[list[Signal], Decrement]:
    decays = [(motion.t, main_displacement(motion.points)) for motion in motions]
    return decays, log_decrement(decays)


def main_displacement(points: Array) -> Array:
    """Displacement from rest (n,) [m] of points (n,dims) along the line on which they move most."""
    moved = points - points[-REST_SAMPLES:].mean(axis=0)
    _, _, directions = np.linalg.svd(moved, full_matrices=False)
    s = moved @ directions[0]
    return np.asarray(s if s[np.argmax(np.abs(s))] > 0 else -s)


def model_modes(actuator: Actuator) -> tuple[float, float]:
    """Undamped angular frequencies [rad/s] of the model's first two modes about its rest."""
    first, second = undamped(build_rod(actuator, actuator.table_rods))[:2]
    return float(first), float(second)


def _measured(found: Decrement) -> tuple[Estimate, ...]:
    zeta, omega = found.zeta, found.omega_d
    hertz = (omega.value / math.tau, omega.low / math.tau, omega.high / math.tau)
    return (
        Estimate("zeta", zeta.value, zeta.low, zeta.high, "1", "measured mode"),
        Estimate("damped frequency", *hertz, "Hz", "measured mode"),
    )


def _rayleigh(zeta: Interval, damped: _Damped) -> tuple[Estimate, ...]:
    actuator, band, _ = damped
    low, high = zeta.low / zeta.value, zeta.high / zeta.value
    values = [("alpha", band.alpha, "1/s"), ("beta", band.beta, "s")]
    ends = {"b, base joint": 0, "b, tip joint": -1} if len(actuator.b) > 1 else {"b": 0}
    values += [(name, actuator.b[end], "N m s/rad") for name, end in ends.items()]
    return (
        *(Estimate(name, value, value * low, value * high, unit) for name, value, unit in values),
        Estimate("lowest zeta between the modes", band.zeta_low, band.zeta_low, band.zeta_low, "1", "of the model"),
    )


def _time_scale(found: Decrement, first: float) -> tuple[str, ...]:
    if abs(found.omega / first - 1.0) < APART:
        return ()
    return (
        f"The measured mode has {found.omega / math.tau:.3g} Hz undamped, the model's first {first / math.tau:.3g} Hz: "
        "static poses fix only stiffness over torque, so with this stiffness the model's poses and damping ratio are "
        "right, its time scale is not.",
    )


def _amplitude_note(found: Decrement) -> tuple[str, ...]:
    """A sentence when the peaks lie on no straight line."""
    height, ratio = neighbours(found)
    if found.log_misfit < CURVED or height.size < 4:
        return ()
    order = np.argsort(height)
    small, large = np.array_split(order, 2)
    return (
        f"Damping depends on amplitude: zeta is {np.median(ratio[large]):.2g} for peaks about "
        f"{MILLI * np.median(height[large]):.2g} mm and {np.median(ratio[small]):.2g} about "
        f"{MILLI * np.median(height[small]):.2g} mm (medians); one linear model has one ratio for all.",
    )
