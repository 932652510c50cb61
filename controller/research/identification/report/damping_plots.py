"""What a report shows of free decays: the motion, its peaks, the damping ratio over amplitude and over frequency."""

import math
from collections.abc import Sequence

import numpy as np

from controller.arrays import Array, Mask
from controller.research.identification.fit import Plot, PlotSeries
from controller.research.identification.motion.damping import Decrement, Peaks, local_ratios
from controller.research.identification.motion.rayleigh import Rayleigh, rayleigh_ratio

DRAWN = 3
"""Decays that are drawn over time."""

FAR = 20.0
"""A peak enters the plot over amplitude when it is this many standard deviations of the noise high."""

MILLI = 1e3


def decays_plot(labels: Sequence[str], decays: Sequence[tuple[Array, Array]]) -> Plot:
    """Displacement of the first few decays over time."""
    drawn = list(zip(labels, decays, strict=True))[:DRAWN]
    lines = [PlotSeries(label, t - t[0], MILLI * s) for label, (t, s) in drawn]
    return Plot("Displacement from rest", "time [s]", "displacement [mm]", tuple(lines))


def peaks_plot(found: Decrement) -> Plot:
    """Logarithms of all peaks over the half periods, each decay from where its own line starts."""
    slope = math.pi * found.zeta.value / math.sqrt(1.0 - found.zeta.value**2)
    logs = []
    for one in found.peaks:
        log = np.log(np.abs(one.s))
        weight = 1.0 / (np.square(one.noise / one.s) + found.log_misfit**2)
        logs.append(log - weight @ (log + slope * one.turn) / weight.sum())
    turns = np.concatenate([one.turn for one in found.peaks])
    line = np.array([0.0, turns.max()])
    return Plot(
        "Logarithmic decrement",
        "half periods",
        "ln(peak / start of the line) [1]",
        (PlotSeries("peaks", turns, np.concatenate(logs), "points"), PlotSeries("fit", line, -slope * line)),
    )


def amplitudes_plot(found: Decrement) -> Plot:
    """Damping ratio over amplitude, from each two neighbouring peaks that stand well out of the noise."""
    height, ratio = neighbours(found)
    line = np.array([height.min(), height.max()]) if height.size else np.zeros(0)
    return Plot(
        "Damping ratio over amplitude",
        "peak [mm]",
        "zeta of two peaks [1]",
        (
            PlotSeries("two neighbouring peaks", MILLI * height, ratio, "points"),
            PlotSeries("fit", MILLI * line, np.full(line.size, found.zeta.value)),
        ),
        log_x=True,
    )


def ratios_plot(found: Decrement, band: Rayleigh, first: float, second: float) -> Plot:
    """Damping ratio of the model over frequency."""
    omega = np.geomspace(0.5 * first, 2.0 * second, 100)
    ratio = np.array([rayleigh_ratio(band.alpha, band.beta, one) for one in omega])
    modes = np.array([first, second])
    return Plot(
        "Damping ratio of the model",
        "frequency [Hz]",
        "zeta [1]",
        (
            PlotSeries("its first two modes", modes / math.tau, np.full(2, found.zeta.value), "points"),
            PlotSeries("alpha / (2 omega) + beta omega / 2", omega / math.tau, ratio),
        ),
    )


def neighbours(found: Decrement) -> tuple[Array, Array]:
    """Height [m] and damping ratio of every two neighbouring peaks that stand well out of the noise."""
    pairs = [local_ratios(one._replace(s=one.s[k], turn=one.turn[k])) for one in found.peaks for k in [_clear(one)]]
    return np.concatenate([height for height, _ in pairs]), np.concatenate([ratio for _, ratio in pairs])


def _clear(one: Peaks) -> Mask:
    return np.asarray(np.abs(one.s) > FAR * one.noise)
