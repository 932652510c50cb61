"""A reference on the twin of the connected rig before it is run: the tick itself, far faster than real time."""

import math
import time
from pathlib import Path

import numpy as np
from numpy.lib.recfunctions import repack_fields

from controller.arrays import Array, Rows
from controller.assembly.controllers.registry import controllers
from controller.assembly.statics import static_map
from controller.errors import DataError, ParameterError, TendrilError
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import blended_torques
from controller.reference.feasible.reach import static_tips
from controller.reference.reference import Reference
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode, Request, RowKind
from controller.schema.parameters import REFERENCE_ROWS, RigParameters, Settings
from controller.simulation.metrics import true_tip
from controller.simulation.run import armed, plan, request, require_mode
from controller.simulation.simulate import Simulation
from server.drawing.messages import DURATION_MIN, DrawingBody, Duration
from server.drawing.picture import Indices, evenly, points, times
from server.drawing.planned import wanted
from server.runs.ahead import with_learned
from server.runs.lap import Order, velocity_gain
from server.runs.laps import allowed_by, first_leg, lap_of
from server.runs.learning.lessons import Lessons
from server.runs.messages import Preview, PreviewBody, PreviewPart
from server.runs.planning import NOTHING
from server.runs.tally import Tally

_NAMES = ["slot", "mode", "cause", "request_cause", "saturated", "p_ref", "p_meas", "twin_backbone"]
FIELDS = repack_fields(np.zeros(0, record_dtype(Telemetry))[_NAMES]).dtype
"""What is kept of a row: minutes of whole ones are hundreds of megabytes."""
PIECE = 1000
"""Ticks from one look at the mode to the next."""
WAY = 2.0
"""Time in which the twin comes to where the rig stands [s]."""
SETTLE = 2.0
"""Time for which the twin stands where the rig does, before the run [s]."""
MEASURES = ("rmse", "max_error", "lag_deg_x", "lag_deg_y")
"""What there is only of a run to the end."""


def predicted(body: PreviewBody, rig: RigParameters, settings: Settings, u: Array, lessons: Path = NOTHING) -> Preview:
    """The run that `body` would be from the torques u (2,) [N m] on, at which the rig stands.

    `lessons` is the folder of what was learned of paths. Raises ParameterError and UnknownReference for what cannot be
    run at all.
    """
    preview = PreviewInParts(body, rig, settings, u, lessons)
    preview.go_on()
    return preview.result()


class PreviewInParts:
    """A run on the twin as far as it has been foreseen; arguments and errors as `predicted`."""

    def __init__(
        self, body: PreviewBody, rig: RigParameters, settings: Settings, u: Array, lessons: Path = NOTHING
    ) -> None:
        begin = time.perf_counter()
        smap = static_map(rig.actuator, rig.controller)
        allowed = allowed_by(rig, settings, drawn=body.drawing is not None)
        self._lap, self._dt = lap_of(wanted(body, rig, settings), rig, body.laps, allowed), rig.controller.dt
        way = first_leg(smap, self._lap, body.laps, u)
        order = Order(self._lap, body.laps, rig, settings, body.learning)
        self._leg = leg = with_learned(way, order, Lessons(lessons))
        own_gains = controllers()[settings.controller].own_gains
        self._K_FF = velocity_gain(self._lap.kind, rig, settings, own_gains)
        before = way_to(smap, u, self._dt)
        self._ahead, self._done = len(before[0]), 0
        _require_room(self._ahead + leg.ticks, body.laps, self._dt)
        row = np.arange(leg.ticks)
        p, u = np.vstack([before[0], leg.p[leg.row(row)]]), np.vstack([before[1], leg.u[leg.row(row)]])
        travelled = np.append(np.ones(self._ahead, bool), leg.travel[leg.row(row)])
        known, fed = self._lap.kind >= RowKind.KNOWN, self._lap.kind == RowKind.FED
        reference = Reference(self._lap.name, p, 0, u=u, travel=travelled, known=known, velocity_feedforward=fed)
        planned = leg.planned_at(row)
        if planned is not None:
            planned = np.vstack([before[1], planned])
        self._simulation = started(rig, reference, settings, planned)
        self._rows = np.zeros(len(p), FIELDS)
        self._shown, self._told = evenly(leg.ticks), 0
        self._seconds = time.perf_counter() - begin

    @property
    def over(self) -> bool:
        """Whether it has been foreseen to its end, or to where it breaks off."""
        return self._done == len(self._rows) or (self._done > 0 and self._rows["mode"][self._done - 1] != Mode.TRACK)

    def go_on(self, seconds: float = math.inf) -> None:
        """Foresee more of it for about so long, a piece at least."""
        begin, spent = time.perf_counter(), 0.0
        while not self.over and spent <= seconds:
            end = min(self._done + PIECE, len(self._rows))
            rows = self._simulation.run(end - self._done)
            self._rows[self._done : end] = repack_fields(rows[_NAMES])
            self._done, spent = end, time.perf_counter() - begin
        self._seconds += spent

    def part(self) -> PreviewPart:
        """What was foreseen since the last part."""
        rows, before = self._followed(), self._shown[self._told - 1] + 1 if self._told else 0
        shown = self._shown[self._told : np.searchsorted(self._shown, len(rows))]
        found = PreviewPart(
            first=self._told,
            t=times(shown * self._dt),
            points=points(true_tip(rows)[shown]),
            saturated=since(rows["saturated"][before:] != 0, shown - before),
            start=self._start,
            progress=self._done / len(self._rows),
            preview=self.result() if self.over else None,
            problem="",
        )
        self._told += len(shown)
        return found

    def result(self) -> Preview:
        """All of it, once it is over."""
        broken = broken_off(self._rows[min(self._ahead, self._done - 1) : self._done], self._lap.name, self._dt)
        rows = self._followed()
        tally = Tally(self._lap.frequency, self._dt)
        tally.add(rows[~self._leg.travel[self._leg.row(np.arange(len(rows)))]])
        figures, shown = tally.figures(), evenly(len(rows))
        return Preview(
            t=times(shown * self._dt),
            points=points(true_tip(rows)[shown]),
            start=int(np.searchsorted(shown, self._leg.again)),
            saturated=since(rows["saturated"] != 0, shown),
            approach=points(self._leg.p[evenly(max(self._leg.again, 1))]),
            K_FF=self._K_FF,
            saturated_share=figures.saturated_share or 0.0,
            broken_off=broken,
            seconds=self._seconds,
            **(dict.fromkeys(MEASURES) if broken else {name: getattr(figures, name) for name in MEASURES}),
        )

    @property
    def _start(self) -> int:
        return int(np.searchsorted(self._shown, self._leg.again))

    def _followed(self) -> Rows:
        """Rows so far from the beginning of the run, as long as the rig follows."""
        rows = self._rows[self._ahead : self._done]
        broken = np.flatnonzero(rows["mode"] != Mode.TRACK)
        return rows[: broken[0]] if broken.size else rows


def warm_up(rig: RigParameters) -> None:
    """Compile, or load from the cache, all that a preview calls: of a path out of reach and too fast."""
    far = DrawingBody(name="far", points=[(0.3, 0.0), (0.3, 0.05)], timing=Duration(duration=DURATION_MIN))
    predicted(PreviewBody(drawing=far), rig, Settings(), np.zeros(2))


def way_to(smap: StaticMap, u: Array, dt: float) -> tuple[Array, Array]:
    """Rows (n, 2) [m] from rest to where the torques u (2,) [N m] hold the tip, and standing there; none for u = 0.

    Rows are dt [s] apart.
    """
    if not u.any():
        return np.empty((0, 2)), np.empty((0, 2))
    torques = np.vstack([blended_torques(np.zeros(2), u, round(WAY / dt)), np.tile(u, (round(SETTLE / dt), 1))])
    return static_tips(smap, torques), torques


def started(rig: RigParameters, reference: Reference, settings: Settings, planned: Array | None) -> Simulation:
    """The twin at rest, about to follow `reference`, by torques `planned` (n, 2) [N m] where there are some."""
    simulation = armed(rig, settings, rig.twin.seed)
    try:
        plan(simulation.rig.control, reference, rig.controller.dt, planned)
    except DataError as error:
        raise ParameterError(str(error)) from error
    request(simulation, Request.TRACK)
    return simulation


def broken_off(rows: Rows, name: str, dt: float) -> str:
    """Why and when the rig does not follow to the end, "" if it does. Rows (n,) are dt [s] apart."""
    try:
        require_mode(rows, name, Mode.TRACK, dt)
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
