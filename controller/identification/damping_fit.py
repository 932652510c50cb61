"""Damping of an actuator from free decays of one tracked body: zeta, and the Rayleigh damping that has it."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from controller.actuator import Actuator
from controller.build import build_rod
from controller.identification.damping import (
    Decrement,
    Interval,
    Peaks,
    Rayleigh,
    local_ratios,
    log_decrement,
    rayleigh,
    rayleigh_ratio,
)
from controller.identification.fit import Estimate, Fit, Misfit, Plot, Series
from controller.kernels.rod import Array
from controller.stability import natural_modes

REST_SAMPLES = 20
"""The rest is the mean of a decay's last samples, as many as this."""

DRAWN = 3
"""Decays that are drawn over time."""

APART = 0.1
"""First modes of data and model that differ by more than this share are reported."""

CURVED = 0.1
"""Scatter of ln(peak) beyond the noise from which on the damping is called dependent on amplitude."""

FAR = 20.0
"""A peak enters the plot over amplitude when it is this many standard deviations of the noise high."""

MILLI = 1e3


class Motion(NamedTuple):
    """A free decay of one tracked body."""

    label: str
    t: Array
    """(n,) [s]."""
    points: Array
    """(n,2) or (n,3) [m]."""


def fit_damping(motions: Sequence[Motion], base: Actuator) -> Fit:
    """Damping ratio of the dominant mode, and alpha and b = beta k of `base` that give it to the model's first mode.

    The band of interest is from the model's first to its second mode; between them the ratio is lower.
    """
    decays = [(motion.t, main_displacement(motion.points)) for motion in motions]
    found = log_decrement(decays)
    first, second = model_modes(base)
    band = rayleigh(found.zeta.value, first, second)
    actuator = base.model_copy(update={"alpha": band.alpha, "b": tuple(band.beta * k for k in base.k)})
    return Fit(
        title="Damping from free decays",
        method=(
            f"Logarithmic decrement of the peaks of {len(motions)} free decays, one line ln(peak) over half periods "
            "each with a common slope. (alpha, beta) give this damping ratio to the model's "
            f"first two modes, {first / math.tau:.3g} and {second / math.tau:.3g} Hz."
        ),
        actuator=actuator,
        parameters=_estimates(found, band, actuator),
        misfits=(Misfit("ln(peak), beyond the noise", found.log_misfit, "1", sum(one.s.size for one in found.peaks)),),
        plots=(_decays(motions, decays), _peaks(found), _amplitudes(found), _ratios(found, band, first, second)),
        notes=(*_time_scale(found, first), *_amplitude_note(found)),
    )


def main_displacement(points: Array) -> Array:
    """Displacement from rest (n,) [m] of points (n,dims) along the line on which they move most."""
    moved = points - points[-REST_SAMPLES:].mean(axis=0)
    _, _, directions = np.linalg.svd(moved, full_matrices=False)
    s = moved @ directions[0]
    return np.asarray(s if s[np.argmax(np.abs(s))] > 0 else -s)


def model_modes(actuator: Actuator) -> tuple[float, float]:
    """Undamped angular frequencies [rad/s] of the model's first two modes about its rest."""
    model = build_rod(actuator, actuator.table_rods)
    loose = model._replace(b=np.zeros_like(model.b), alpha=0.0)
    omegas = np.sort(np.abs(natural_modes(loose, model.rest)))[::2]
    return float(omegas[0]), float(omegas[1])


def _estimates(found: Decrement, band: Rayleigh, actuator: Actuator) -> tuple[Estimate, ...]:
    zeta = found.zeta

    def scaled(name: str, value: float, unit: str) -> Estimate:
        return Estimate(name, value, value * zeta.low / zeta.value, value * zeta.high / zeta.value, unit)

    hertz = Interval(*(omega / math.tau for omega in (found.omega_d.value, found.omega_d.low, found.omega_d.high)))
    ends = [("b", 0)] if len(actuator.b) == 1 else [("b, base joint", 0), ("b, tip joint", -1)]
    return (
        Estimate("zeta", zeta.value, zeta.low, zeta.high, "1", "measured mode"),
        Estimate("damped frequency", hertz.value, hertz.low, hertz.high, "Hz", "measured mode"),
        scaled("alpha", band.alpha, "1/s"),
        scaled("beta", band.beta, "s"),
        *(scaled(name, actuator.b[end], "N m s/rad") for name, end in ends),
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


def _decays(motions: Sequence[Motion], decays: Sequence[tuple[Array, Array]]) -> Plot:
    drawn = list(zip(motions, decays, strict=True))[:DRAWN]
    lines = [Series(motion.label, t - t[0], MILLI * s) for motion, (t, s) in drawn]
    return Plot("Displacement from rest", "time [s]", "displacement [mm]", tuple(lines))


def _peaks(found: Decrement) -> Plot:
    """Logarithms of all peaks over the half periods, each decay shifted to its own line's start."""
    slope = math.pi * found.zeta.value / math.sqrt(1.0 - found.zeta.value**2)
    shifted = [np.log(np.abs(one.s)) - _start(one.turn, one.s, slope) for one in found.peaks]
    turns = np.concatenate([one.turn for one in found.peaks])
    line = np.array([0.0, turns.max()])
    return Plot(
        "Logarithmic decrement",
        "half periods",
        "ln(peak / first peak) [1]",
        (Series("peaks", turns, np.concatenate(shifted), "points"), Series("fit", line, -slope * line)),
    )


def _start(turn: Array, s: Array, slope: float) -> float:
    weight = np.square(s)
    return float(weight @ (np.log(np.abs(s)) + slope * turn) / weight.sum())


def _amplitudes(found: Decrement) -> Plot:
    """Damping ratio over amplitude, from each two neighbouring peaks that stand well out of the noise."""
    height, ratio = _neighbours(found)
    line = np.array([height.min(), height.max()]) if height.size else np.zeros(0)
    return Plot(
        "Damping ratio over amplitude",
        "peak [mm]",
        "zeta of two peaks [1]",
        (
            Series("two neighbouring peaks", MILLI * height, ratio, "points"),
            Series("fit", MILLI * line, np.full(line.size, found.zeta.value)),
        ),
        log_x=True,
    )


def _amplitude_note(found: Decrement) -> tuple[str, ...]:
    """A sentence when the peaks lie on no straight line."""
    height, ratio = _neighbours(found)
    if found.log_misfit < CURVED or height.size < 4:
        return ()
    order = np.argsort(height)
    small, large = np.array_split(order, 2)
    return (
        f"Damping depends on amplitude: zeta is {np.median(ratio[large]):.2g} for peaks about "
        f"{MILLI * np.median(height[large]):.2g} mm and {np.median(ratio[small]):.2g} about "
        f"{MILLI * np.median(height[small]):.2g} mm (medians); one linear model has one ratio for all.",
    )


def _neighbours(found: Decrement) -> tuple[Array, Array]:
    pairs = [local_ratios(one._replace(s=one.s[k], turn=one.turn[k])) for one in found.peaks for k in [_clear(one)]]
    return np.concatenate([height for height, _ in pairs]), np.concatenate([ratio for _, ratio in pairs])


def _clear(one: Peaks) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return np.asarray(np.abs(one.s) > FAR * one.noise)


def _ratios(found: Decrement, band: Rayleigh, first: float, second: float) -> Plot:
    omega = np.geomspace(0.5 * first, 2.0 * second, 100)
    ratio = np.array([rayleigh_ratio(band.alpha, band.beta, one) for one in omega])
    modes = np.array([first, second])
    return Plot(
        "Damping ratio of the model",
        "frequency [Hz]",
        "zeta [1]",
        (
            Series("its first two modes", modes / math.tau, np.full(2, found.zeta.value), "points"),
            Series("alpha / (2 omega) + beta omega / 2", omega / math.tau, ratio),
        ),
    )
