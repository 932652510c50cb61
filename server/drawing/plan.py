"""What the page gets to know of a drawing's plan, and the same plan as a file."""

import io

import numpy as np

from controller.arrays import Array
from controller.reference.feasible.bounds import accelerations, speeds, standing
from controller.schema.parameters import RigParameters, Settings
from server.drawing.messages import DrawingBody, DrawingPlan
from server.drawing.picture import evenly, points, times
from server.drawing.planned import plan
from server.drawing.strokes import length_of


def drawing_plan(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> DrawingPlan:
    """What would be followed. Raises ParameterError for what cannot be timed."""
    found, dt = plan(drawing, rig, settings), rig.controller.dt
    path, rows = found.path, evenly(len(found.path.p))
    out, drawn = path.distance > 0.0, judged(path.p, path.travel)
    return DrawingPlan(
        length=length_of(drawn),
        duration=(len(path.p) - 1) * dt,
        approach=found.reference.start * dt,
        travel_duration=int(path.travel.sum()) * dt,
        peak_speed=max(float(speeds(p, dt).max(initial=0.0)) for p in drawn),
        peak_acceleration=max(float(accelerations(standing(p, dt), dt).max(initial=0.0)) for p in drawn),
        t=times(rows * dt),
        points=points(path.p[rows]),
        wished=points(path.wished[rows]),
        inside=(~out[rows]).tolist(),
        travel=path.travel[rows].tolist(),
        outside_share=found.outside_share,
        reachable=drawing.outside == "project" or not out.any(),
        reason="; ".join(filter(None, [found.outside(), *path.said])),
    )


def judged(p: Array, travel: np.ndarray) -> list[Array]:
    """The stretches of rows p (n, 2) [m] that are no `travel` (n,) of bool."""
    cuts = 1 + np.flatnonzero(travel[1:] != travel[:-1])
    return [part for part, travelled in zip(np.split(p, cuts), np.split(travel, cuts), strict=True) if not travelled[0]]


def csv_of(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> str:
    """What would be followed as t, x, y every tick, as `tendril track` reads it. Raises ParameterError."""
    p, dt = plan(drawing, rig, settings).path.p, rig.controller.dt
    text = io.StringIO()
    table = np.column_stack([np.arange(len(p)) * dt, p])
    np.savetxt(text, table, fmt=("%.4f", "%.7f", "%.7f"), delimiter=",", header="t_s,x_m,y_m", comments="")
    return text.getvalue()
