"""What a report shows of a modal fit: bodies over time, and the profile."""

from collections.abc import Sequence

import numpy as np

from controller.arrays import Array
from controller.assembly.rod import profile
from controller.research.identification.fit import Plot, PlotSeries
from controller.research.identification.plane import PlaneMotion
from controller.schema.actuator import Actuator

DRAWN = 3
"""Decays that are drawn over time."""
SECONDS = 1.5
MILLI = 1e3


def modal_plots(motions: Sequence[PlaneMotion], lateral: Sequence[Array], actuator: Actuator) -> tuple[Plot, ...]:
    """The inner bodies of some decays, measured and estimated, all their errors, and the joints' stiffness."""
    pairs = list(zip(motions, lateral, strict=True))
    return (*(_decay(one, found) for one, found in pairs[:DRAWN]), _errors(pairs), _stiffness(actuator))


def _decay(motion: PlaneMotion, lateral: Array) -> Plot:
    drawn = motion.t <= SECONDS
    t, inner = motion.t[drawn], range(lateral.shape[1] - 1)
    measured = [PlotSeries(f"body {i + 1}", t, MILLI * motion.lateral[drawn, i], "points") for i in inner]
    model = [PlotSeries(f"body {i + 1}, estimated", t, MILLI * lateral[drawn, i]) for i in inner]
    return Plot(f"ID {motion.id}", "time [s]", "lateral motion [mm]", (*measured, *model))


def _errors(pairs: Sequence[tuple[PlaneMotion, Array]]) -> Plot:
    series = []
    for body in range(pairs[0][1].shape[1] - 1):
        off = [np.append(MILLI * (found[:, body] - one.lateral[:, body]), np.nan) for one, found in pairs]
        t = [np.append(one.t, np.nan) for one, _ in pairs]
        series.append(PlotSeries(f"body {body + 1}", np.concatenate(t), np.concatenate(off)))
    return Plot("Errors of the inner bodies", "time [s]", "estimate minus measured [mm]", tuple(series))


def _stiffness(actuator: Actuator) -> Plot:
    k = profile(actuator.k, actuator.table_rods)
    return Plot(
        "Joint stiffness", "joint, from the base", "k [N m/rad]", (PlotSeries("", np.arange(1.0, k.size + 1), k),)
    )
