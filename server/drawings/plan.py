"""What the page gets to know of a drawing's plan, and the same plan as a file."""

import io
from typing import Any

import numpy as np

from controller.kernels.rod import Array
from controller.parameters import RigParameters, Settings
from controller.reference.shapes import lengths
from server.drawings.messages import DrawingBody, DrawingPlan
from server.drawings.planned import Planned, plan
from server.references import POINTS, points, times

WINDOW = 0.02
"""Time over which an acceleration is taken [s]."""

Indices = np.ndarray[Any, np.dtype[np.intp]]


def drawing_plan(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> DrawingPlan:
    """What would be followed. Raises ParameterError for what cannot be timed."""
    found, dt = plan(drawing, rig, settings), rig.controller.dt
    p, out = found.path.p, found.path.distance > 0.0
    rows = spread(len(p))
    return DrawingPlan(
        length=float(lengths(p)[-1]),
        duration=(len(p) - 1) * dt,
        approach=found.reference.start * dt,
        peak_speed=float(np.diff(lengths(p)).max(initial=0.0)) / dt,
        peak_acceleration=peak_acceleration(p, dt),
        t=times(rows * dt),
        points=points(p[rows]),
        wished=points(found.wished[rows]),
        inside=(~out[rows]).tolist(),
        outside_share=float(out.mean()),
        reachable=drawing.outside == "project" or not out.any(),
        reason=reason(found, dt),
    )


def reason(found: Planned, dt: float) -> str:
    """What there is to say of the reach; "" for nothing."""
    said = [found.outside()] if found.outside() else []
    if found.path.changes:
        when = ", ".join(f"{row * dt:.3g}" for row in found.path.changes[:3])
        more = " and more" if len(found.path.changes) > 3 else ""
        said.append(f"at {when} s{more} it can only go on in another pose of the arm")
    return "; ".join(said)


def peak_acceleration(p: Array, dt: float) -> float:
    """Largest |p(t + T) - 2 p(t) + p(t - T)| / T^2 [m/s^2] along rows p (n, 2) [m], T = 20 ms: corners are finite."""
    apart = max(1, round(WINDOW / dt))
    change = p[2 * apart :] - 2.0 * p[apart:-apart] + p[: -2 * apart]
    return float(np.linalg.norm(change, axis=1).max(initial=0.0)) / (apart * dt) ** 2


def spread(rows: int) -> Indices:
    """At most POINTS of so many `rows`, evenly, the last included."""
    return np.unique(np.linspace(0, rows - 1, min(rows, POINTS)).round().astype(np.intp))


def csv_of(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> str:
    """What would be followed as t, x, y every tick, as `tendril track` reads it. Raises ParameterError."""
    p, dt = plan(drawing, rig, settings).path.p, rig.controller.dt
    text = io.StringIO()
    table = np.column_stack([np.arange(len(p)) * dt, p])
    np.savetxt(text, table, fmt=("%.4f", "%.7f", "%.7f"), delimiter=",", header="t_s,x_m,y_m", comments="")
    return text.getvalue()
