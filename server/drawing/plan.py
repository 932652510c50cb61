"""What the page gets to know of a drawing's plan, and the same plan as a file."""

import io

import numpy as np

from controller.reference.feasible.bounds import accelerations, speeds, standing
from controller.reference.shapes import lengths
from controller.schema.parameters import RigParameters, Settings
from server.drawing.messages import DrawingBody, DrawingPlan
from server.drawing.picture import evenly, points, times
from server.drawing.planned import plan


def drawing_plan(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> DrawingPlan:
    """What would be followed. Raises ParameterError for what cannot be timed."""
    found, dt = plan(drawing, rig, settings), rig.controller.dt
    path, rows = found.path, evenly(len(found.path.p))
    out = path.distance > 0.0
    return DrawingPlan(
        length=float(lengths(path.p)[-1]),
        duration=(len(path.p) - 1) * dt,
        approach=found.reference.start * dt,
        peak_speed=float(speeds(path.p, dt).max(initial=0.0)),
        peak_acceleration=float(accelerations(standing(path.p, dt), dt).max(initial=0.0)),
        t=times(rows * dt),
        points=points(path.p[rows]),
        wished=points(path.wished[rows]),
        inside=(~out[rows]).tolist(),
        travel=path.travel[rows].tolist(),
        outside_share=float(out.mean()),
        reachable=drawing.outside == "project" or not out.any(),
        reason="; ".join(filter(None, [found.outside(), *path.said])),
    )


def csv_of(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> str:
    """What would be followed as t, x, y every tick, as `tendril track` reads it. Raises ParameterError."""
    p, dt = plan(drawing, rig, settings).path.p, rig.controller.dt
    text = io.StringIO()
    table = np.column_stack([np.arange(len(p)) * dt, p])
    np.savetxt(text, table, fmt=("%.4f", "%.7f", "%.7f"), delimiter=",", header="t_s,x_m,y_m", comments="")
    return text.getvalue()
