"""A reference on the twin of the connected rig before it is run: the tick itself, far faster than real time."""

import math
import time
from dataclasses import replace

import numpy as np
from numpy.lib.recfunctions import repack_fields

from controller.build_rig import REFERENCE_ROWS
from controller.errors import DataError, ParameterError, TendrilError
from controller.experiments.metrics import lags, rmse, true_tip
from controller.experiments.run import armed, plan, request, require_mode
from controller.experiments.simulate import Rows
from controller.kernels.rod import Array
from controller.modes import Mode, Request
from controller.parameters import RigParameters, Settings
from controller.reference.reference import Reference
from server.drawings.messages import DURATION_MIN, DrawingBody, Duration, Preview, PreviewBody
from server.drawings.plan import Indices, points, spread, times
from server.drawings.planned import named, planned
from server.runs.laps import lap_of

MEASURES = ("rmse", "max_error", "lag_deg_x", "lag_deg_y")
"""What there is only of a run to the end."""
FIELDS = ["mode", "cause", "request_cause", "saturated", "p_meas", "twin_backbone"]
"""What is kept of a row: minutes of whole ones are hundreds of megabytes."""
PIECE = 10_000
"""Ticks from one look at the mode to the next."""


def predicted(body: PreviewBody, rig: RigParameters, settings: Settings) -> Preview:
    """What comes of it. Raises ParameterError and UnknownReference for what cannot be run at all."""
    begin = time.perf_counter()
    reference = wanted(body, rig, settings)
    rows = foreseen(rig, reference, settings)
    broken = broken_off(rows, reference.name)
    rows = rows[rows["mode"] == Mode.TRACK]
    shown = spread(len(rows))
    saturated = rows["saturated"] != 0
    return Preview(
        t=times(shown, rig.controller.dt),
        points=points(true_tip(rows)[shown]),
        start=int(np.searchsorted(shown, reference.start)),
        saturated=since(saturated, shown),
        saturated_share=float(saturated[reference.start :].mean()) if len(rows) > reference.start else 0.0,
        broken_off=broken,
        seconds=time.perf_counter() - begin,
        **(dict.fromkeys(MEASURES) if broken else measures(reference, rows["p_meas"])),
    )


def warm_up(rig: RigParameters) -> None:
    """Compile, or load from the cache, all that a preview calls."""
    far = DrawingBody(name="far", points=[(-1.0, 1.0), (-1.0, 0.99)], timing=Duration(duration=DURATION_MIN))
    predicted(PreviewBody(drawing=far), rig, Settings())


def wanted(body: PreviewBody, rig: RigParameters, settings: Settings) -> Reference:
    """The reference that `body` asks for, with its laps. Raises ParameterError where they are too long."""
    if body.drawing is not None:
        reference = planned(body.drawing, rig, settings)
    else:
        reference = named(str(body.reference), rig)
    if body.laps == 1:
        return reference
    lap, dt = lap_of(reference, rig, body.laps), rig.controller.dt
    rows = reference.start + lap.rows(body.laps)
    if rows > REFERENCE_ROWS:
        raise ParameterError(f"laps = {body.laps}: {rows * dt:.4g} s, more than {REFERENCE_ROWS * dt:g} s")
    return replace(reference, p=np.vstack([reference.p[: reference.start], *[lap.p] * body.laps])[:rows])


def foreseen(rig: RigParameters, reference: Reference, settings: Settings) -> Rows:
    """FIELDS of the telemetry (n,) on the twin, from rest; where it breaks off, to the end of that piece."""
    simulation = armed(rig, settings, rig.twin.seed)
    try:
        plan(simulation.rig.control, reference)
    except DataError as error:
        raise ParameterError(str(error)) from error
    request(simulation, Request.TRACK)
    pieces: list[Rows] = []
    for begin in range(0, len(reference.p), PIECE):
        rows = simulation.run(min(PIECE, len(reference.p) - begin))
        pieces.append(repack_fields(rows[FIELDS]))
        if rows["mode"][-1] != Mode.TRACK:
            break
    return np.concatenate(pieces)


def broken_off(rows: Rows, name: str) -> str:
    """Why and when the rig does not follow to the end, "" if it does."""
    try:
        require_mode(rows, name, Mode.TRACK)
    except TendrilError as error:
        return str(error)
    return ""


def measures(reference: Reference, tip: Array) -> dict[str, float | None]:
    """Errors and lags after the approach of the measured tip (n, 2) [m]: a run's result has no other."""
    e = (reference.p - tip)[reference.start :]
    lag = lags(reference, tip)
    found = {"rmse": rmse(e), "max_error": float(np.linalg.norm(e, axis=1).max()), **lag}
    return {name: found[name] if math.isfinite(found.get(name, math.nan)) else None for name in MEASURES}


def since(flags: Array, shown: Indices) -> list[bool]:
    """Whether any of `flags` (n,) is up at a row of `shown` (m,), or since the row before it."""
    if not len(shown):
        return []
    up: list[bool] = np.logical_or.reduceat(flags, np.concatenate([[0], shown[:-1] + 1])).tolist()
    return up
