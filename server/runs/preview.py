"""A reference on the twin of the connected rig before it is run: the tick itself, far faster than real time."""

import time

import numpy as np
from numpy.lib.recfunctions import repack_fields

from controller.arrays import Array, Rows
from controller.errors import DataError, ParameterError, TendrilError
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import blended_torques
from controller.reference.feasible.reach import static_tips
from controller.reference.library import static_map
from controller.reference.reference import Reference
from controller.schema.modes import Mode, Request
from controller.schema.parameters import REFERENCE_ROWS, RigParameters, Settings
from controller.simulation.metrics import true_tip
from controller.simulation.run import armed, plan, request, require_mode
from server.drawing.messages import DURATION_MIN, DrawingBody, Duration
from server.drawing.picture import Indices, evenly, points, times
from server.drawing.planned import wanted
from server.runs.laps import allowed_by, first_leg, lap_of
from server.runs.messages import Preview, PreviewBody
from server.runs.tally import Tally

FIELDS = ["slot", "mode", "cause", "request_cause", "saturated", "p_ref", "p_meas", "twin_backbone"]
"""What is kept of a row: minutes of whole ones are hundreds of megabytes."""
PIECE = 10_000
"""Ticks from one look at the mode to the next."""
WAY = 2000
"""Ticks in which the twin comes to where the rig stands."""
SETTLE = 2000
"""Ticks for which the twin stands where the rig does, before the run."""
MEASURES = ("rmse", "max_error", "lag_deg_x", "lag_deg_y")
"""What there is only of a run to the end."""


def predicted(body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> Preview:
    """The run that `body` would be from the torques u (2,) [N m] on, at which the rig stands.

    Raises ParameterError and UnknownReference for what cannot be run at all.
    """
    begin = time.perf_counter()
    smap = static_map(rig.actuator, rig.controller)
    allowed = allowed_by(rig, settings, drawn=body.drawing is not None)
    lap = lap_of(wanted(body, rig, settings), rig, body.laps, allowed)
    leg = first_leg(smap, lap, body.laps, u)
    before = way_to(smap, u)
    _require_room(len(before[0]) + leg.ticks, body.laps, rig.controller.dt)
    row, first = leg.row(np.arange(leg.ticks)), len(before[0])
    p, u = np.vstack([before[0], leg.p[row]]), np.vstack([before[1], leg.u[row]])
    travelled = np.append(np.ones(first, bool), leg.travel[row])
    rows = foreseen(rig, Reference(lap.name, p, 0, u=u, travel=travelled, known=lap.known), settings)[first:]
    broken = broken_off(rows, lap.name)
    rows = rows[rows["mode"] == Mode.TRACK]
    tally = Tally(lap.frequency)
    tally.add(rows[~leg.travel[row[: len(rows)]]])
    figures, shown = tally.figures(), evenly(len(rows))
    return Preview(
        t=times(shown * rig.controller.dt),
        points=points(true_tip(rows)[shown]),
        start=int(np.searchsorted(shown, leg.again)),
        saturated=since(rows["saturated"] != 0, shown),
        saturated_share=figures.saturated_share or 0.0,
        broken_off=broken,
        seconds=time.perf_counter() - begin,
        **(dict.fromkeys(MEASURES) if broken else {name: getattr(figures, name) for name in MEASURES}),
    )


def warm_up(rig: RigParameters) -> None:
    """Compile, or load from the cache, all that a preview calls."""
    far = DrawingBody(name="far", points=[(-1.0, 1.0), (-1.0, 0.99)], timing=Duration(duration=DURATION_MIN))
    predicted(PreviewBody(drawing=far), rig, Settings(), np.zeros(2))


def way_to(smap: StaticMap, u: Array) -> tuple[Array, Array]:
    """Rows (n, 2) [m] from rest to where the torques u (2,) [N m] hold the tip, and standing there; none for u = 0."""
    if not u.any():
        return np.empty((0, 2)), np.empty((0, 2))
    torques = np.vstack([blended_torques(np.zeros(2), u, WAY), np.tile(u, (SETTLE, 1))])
    return static_tips(smap, torques), torques


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


def since(flags: Array, shown: Indices) -> list[bool]:
    """Whether any of `flags` (n,) is up at a row of `shown` (m,), or since the row before it."""
    if not len(shown):
        return []
    up: list[bool] = np.logical_or.reduceat(flags, np.concatenate([[0], shown[:-1] + 1])).tolist()
    return up


def _require_room(rows: int, laps: int, dt: float) -> None:
    if rows > REFERENCE_ROWS:
        raise ParameterError(f"laps = {laps}: {rows * dt:.4g} s, more than {REFERENCE_ROWS * dt:g} s")
