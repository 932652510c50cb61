"""What a report shows of a fit to static poses: shapes, measured over model, residuals."""

import numpy as np

from controller.arrays import Array
from controller.assembly.rod import build_rod, profile
from controller.research.identification.fit import Misfit, Plot, PlotSeries
from controller.research.identification.poses import Poses, backbones, fine, torques
from controller.research.identification.regression import spread
from controller.schema.actuator import Actuator

OUTLIER = 5.0
"""A value this many robust standard deviations off is called an outlier."""

SHAPES = 12
"""Poses that are drawn; more would hide one another."""

MILLI, KILO = 1e3, 1e-3


def marker_misfits(poses: Poses, residual: Array) -> tuple[Misfit, ...]:
    """Rms of x and y of each marker, and of all; residual (n m 2,) [m]."""
    by_marker = MILLI * residual.reshape(poses.points.shape)
    each = [
        Misfit(f"marker {i + 1}, s = {MILLI * s:.0f} mm", _rms(by_marker[:, i]), "mm", by_marker[:, i].size)
        for i, s in enumerate(poses.arcs)
    ]
    return (*each, Misfit("all markers", _rms(by_marker), "mm", by_marker.size)) if len(each) > 1 else tuple(each)


def outlier_notes(poses: Poses, residual: Array, robust: bool) -> tuple[str, ...]:
    """One sentence when values lie far out, with the worst one's line."""
    limit = OUTLIER * spread(residual)
    out = np.abs(residual) > limit
    if not out.any():
        return ()
    row, marker, axis = np.unravel_index(int(np.argmax(np.abs(residual))), poses.points.shape)
    return (
        f"{out.sum()} of {out.size} values are more than {MILLI * limit:.2g} mm off ({OUTLIER:.0f} standard deviations "
        f"of the bulk), the worst by {MILLI * float(np.abs(residual).max()):.2g} mm: {'xy'[axis]}{marker + 1} in line "
        f"{poses.lines[row]:.0f}" + ("." if robust else "; --robust weighs them down."),
    )


def static_plots(poses: Poses, actuator: Actuator, residual: Array) -> tuple[Plot, ...]:
    """Four panels."""
    return (
        _shapes(poses, actuator),
        _parity(poses, residual),
        _residuals(poses, residual),
        _stiffness(actuator),
    )


def _shapes(poses: Poses, actuator: Actuator) -> Plot:
    """Backbones of some poses, one line with gaps, and their markers."""
    chosen = np.unique(np.linspace(0, len(poses.points) - 1, SHAPES).round().astype(int))
    model = build_rod(actuator, fine(actuator))
    joints = backbones(model, *torques(actuator, poses.chambers[chosen]))
    gaps = MILLI * np.pad(joints, ((0, 0), (0, 0), (0, 1)), constant_values=np.nan)
    points = MILLI * poses.points[chosen]
    return Plot(
        "Poses" if len(chosen) == len(poses.points) else f"{len(chosen)} of {len(poses.points)} poses",
        "x [mm]",
        "y [mm]",
        (
            PlotSeries("measured", points[..., 0].ravel(), points[..., 1].ravel(), "points"),
            PlotSeries("model", gaps[:, 0].ravel(), gaps[:, 1].ravel()),
        ),
        equal_axes=True,
    )


def _parity(poses: Poses, residual: Array) -> Plot:
    """Every measured coordinate over the model's."""
    measured = MILLI * poses.points
    model = measured + MILLI * residual.reshape(poses.points.shape)
    ends = np.array([measured.min(), measured.max()])
    axes = [PlotSeries(axis, model[..., i].ravel(), measured[..., i].ravel(), "points") for i, axis in enumerate("xy")]
    return Plot("All markers", "model [mm]", "measured [mm]", (*axes, PlotSeries("equal", ends, ends)))


def _residuals(poses: Poses, residual: Array) -> Plot:
    """Residual of all markers over the pressure, x and y."""
    off = MILLI * residual.reshape(poses.points.shape)
    total = KILO * np.repeat(poses.pressure.sum(axis=1), off.shape[1])
    return Plot(
        "Residuals, model minus measured",
        "p1 + p2 [kPa]",
        "residual [mm]",
        tuple(PlotSeries(axis, total, off[..., i].ravel(), "points") for i, axis in enumerate("xy")),
    )


def _stiffness(actuator: Actuator) -> Plot:
    k = MILLI * profile(actuator.k, actuator.table_rods)
    joint = np.arange(1.0, k.size + 1)
    return Plot("Joint stiffness", "joint, from the base", "k [mN m/rad]", (PlotSeries("", joint, k),))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
