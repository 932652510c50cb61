"""From a reference to one lap of it, and to the rows that lead the rig into it, from wherever its own reference is."""

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.kernels.control.inverse import TOLERANCE
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.bounds import place_of_row, stretches, window_rows, worst
from controller.reference.feasible.travel import TRAVEL_MIN_S, Pose, held_by, travel
from controller.reference.feasible.within_reach import projected
from controller.reference.reference import Reference
from controller.schema.parameters import REFERENCE_ROWS, RigParameters, Settings
from server.drawing.planned import operator_limits, rig_limits
from server.runs.lap import Allowed, Lap, Leg, Place

APPROACH = 2.0
"""Least time from where the rig's reference is to the shape, and of the way back from its end to its start [s]."""
SETTLE = 1.5
"""Time at the first point before the shape begins: what is left of the error then is the shape's own. Without it a slow
digit's largest error was that of its approach (6.6 mm, and 1.8 with it) [s]."""
SHORT_APPROACH = 0.5
"""The same back onto a path that was left within SHORT_WAY [s]."""
SHORT_WAY = 10e-3
"""[m]"""
PAUSE = 0.1
"""Least time at a seam at which the arm has nowhere to go back to, but is too fast to go on at once [s]."""
AT_START = 5e-4
"""A tip that stands so near to the first point, in the same pose of the arm, needs no approach [m]."""
SAME_POSE = 1e-3
"""Torques that differ by less are one pose of the arm [N m]."""
RUN_UP, RUN_UP_MAX = 0.1, 20.0
"""Shortest and longest time in which a path that was left in motion is joined from rest [s]."""
ON_GRID = 1e-6
"""So near to a tick a period ends on it [ticks]."""


def lap_of(reference: Reference, rig: RigParameters, laps: int | None, allowed: Allowed | None = None) -> Lap:
    """`reference` once, or closed if it is to be repeated: by its period, by its steps, or by a way back in u.

    `allowed`: what the operator allows; the settings at the start without it. Raises ParameterError if it does not fit
    the rig's memory.
    """
    allowed = allowed or allowed_by(rig, Settings(), drawn=False)
    smap, begin, start = static_map(rig.actuator, rig.controller), reference.led, reference.start
    u = projected(smap, reference.p[begin:]).u if reference.u is None else reference.u[begin:]
    lead, shape, lead_u, torques = reference.p[begin:start], reference.p[start:], u[: start - begin], u[start - begin :]
    marked = np.zeros(len(shape), bool) if reference.travel is None else reference.travel[start:]
    steps = tuple(row - start for row in reference.steps)
    period = period_rows(reference, len(shape), allowed.dt)
    way_back = np.empty((0, 2)), np.empty((0, 2))
    if laps != 1 and not steps:
        if period and _goes_on(shape[:period], torques[:period], allowed):
            shape, torques, marked = shape[:period], torques[:period], marked[:period]
        elif _closes(shape, torques) and _goes_on(shape[:-1], torques[:-1], allowed):
            shape, torques, marked = shape[:-1], torques[:-1], marked[:-1]
        else:
            least = PAUSE if _closes(shape, torques) else APPROACH
            end, again = Pose(shape[-1], torques[-1]), Pose(shape[0], torques[0])
            p, u = travel(smap, end, again, allowed.travel, allowed.dt, least)
            way_back = p[1:], u[1:]
    back = len(way_back[0])
    _require_room(round((APPROACH + SETTLE) / allowed.dt) + len(lead) + len(shape) + back, allowed.dt)
    return Lap(
        name=reference.name,
        lead=lead,
        p=np.vstack([shape, way_back[0]]),
        back=back,
        u=np.vstack([lead_u, torques, way_back[1]]),
        frequency=None if back else frequencies_of(reference),
        travel=np.concatenate([marked, np.ones(back, bool)]),
        allowed=allowed,
        kind=reference.kind,
        steps=steps,
    )


def allowed_by(rig: RigParameters, settings: Settings, drawn: bool) -> Allowed:
    """What `settings` allow a drawing; the paper's own references keep within the rig's own limits instead."""
    operator = operator_limits(rig, settings)
    return Allowed(operator if drawn else rig_limits(rig), operator, rig.controller.dt)


def _stands_at(here: Pose, there: Pose) -> bool:
    """Whether `here` is `there` to within what a hold leaves."""
    return bool(np.linalg.norm(here.p - there.p) < AT_START and np.abs(here.u - there.u).max() < SAME_POSE)


def _closes(p: Array, u: Array) -> bool:
    """Whether rows end where they begin, in the same pose of the arm."""
    return bool(np.linalg.norm(p[-1] - p[0]) < TOLERANCE and np.abs(u[-1] - u[0]).max() < SAME_POSE)


def _goes_on(p: Array, u: Array, allowed: Allowed) -> bool:
    """Whether the first row may come after the last one at once."""
    apart = 2 * window_rows(allowed.dt)
    seam_p, seam_u = (np.vstack([rows[-apart:], rows[:apart]]) for rows in (p, u))
    return worst(seam_p, seam_u, allowed.shape, allowed.dt) is None


def frequencies_of(reference: Reference) -> tuple[float, float] | None:
    """At which x and y swing [Hz]; None where it is not periodic."""
    if reference.frequency is None:
        return None
    return reference.axis_frequencies or (reference.frequency, reference.frequency)


def period_rows(reference: Reference, rows: int, dt: float) -> int:
    """Rows of as many whole periods as `rows` hold and as end on a tick, or nearest to one; 0 without a period."""
    if reference.frequency is None:
        return 0
    one = 1.0 / (reference.frequency * dt)
    counts = np.arange(1, int(rows / one + ON_GRID) + 1)
    if not counts.size:
        return 0
    off = np.abs(counts * one - np.round(counts * one))
    return round(one * int(counts[off <= off.min() + ON_GRID][-1]))


def first_leg(smap: StaticMap, lap: Lap, laps: int | None, u: Array) -> Leg:
    """From the torques u (2,) [N m] at which the rig is, for these laps. ParameterError beyond the limits."""
    first = lap.lead[0] if len(lap.lead) else lap.p[0]
    here, there = held_by(smap, u), Pose(first, lap.u[0])
    least = TRAVEL_MIN_S if _stands_at(here, there) else APPROACH
    p, led_u = travel(smap, here, there, lap.allowed.travel, lap.allowed.dt, least)
    waits = 0 if len(lap.lead) or _stands_at(here, there) else round(SETTLE / lap.allowed.dt)
    p, led_u = np.vstack([p, np.tile(there.p, (waits, 1))]), np.vstack([led_u, np.tile(there.u, (waits, 1))])
    led = np.vstack([p, lap.lead])
    unjudged = np.ones(len(led), bool)
    return checked(
        Leg(
            p=np.vstack([led, lap.p]),
            u=np.vstack([led_u, lap.u]),
            travel=np.concatenate([unjudged, lap.travel]),
            again=len(led),
            done=0,
            ticks=len(led) + lap.rows(laps),
            kind=lap.kind,
            steps=bool(lap.steps),
        ),
        lap,
    )


def next_leg(smap: StaticMap, lap: Lap, laps: int | None, u: Array, left: Place) -> Leg:
    """From the torques u (2,) [N m] at which the rig is back to where the path was left, and on to the end.

    What was left in motion is joined in motion: the run-up begins on the path before that place. Raises ParameterError
    beyond the limits.
    """
    if not left.done:
        return first_leg(smap, lap, laps, u)
    seconds = RUN_UP
    while True:
        rows = run_up(left.done, seconds, lap.allowed.dt)
        leg = _joined_leg(smap, lap, laps, u, left.done, rows)
        if seconds >= RUN_UP_MAX or not rows[0] or excess_of(leg, lap) is None:
            return checked(leg, lap)
        seconds *= 1.5


def run_up(done: int, seconds: float, dt: float) -> Array:
    """Where on the path (k,) [rows, not whole] a run-up of `seconds` is at every tick, to be at row `done` next.

    From rest, and from the path's own pace on; from its first row where there are not as many before.
    """
    ticks = round(seconds / dt)
    x = np.arange(ticks) / ticks
    at = done - 0.5 * ticks + ticks * (x**3 - 0.5 * x**4)
    return np.arange(done, dtype=float) if at[0] < 0.0 else at


def _joined_leg(smap: StaticMap, lap: Lap, laps: int | None, u: Array, done: int, rows: Array) -> Leg:
    """The travel to the first of `rows` (k,) of the path, those rows, and what is left of the laps from `done` on."""
    n, torques = len(lap.p), lap.torques
    lower = np.floor(rows).astype(int)
    share = (rows - lower)[:, None]
    up_p, up_u = (a[lower % n] + share * (a[(lower + 1) % n] - a[lower % n]) for a in (lap.p, torques))
    here, there = held_by(smap, u), Pose(up_p[0], up_u[0])
    least = SHORT_APPROACH if np.linalg.norm(here.p - there.p) < SHORT_WAY else APPROACH
    p, led_u = travel(smap, here, there, lap.allowed.travel, lap.allowed.dt, least)
    led = len(p) + len(rows)
    return Leg(
        p=np.vstack([p, up_p, np.roll(lap.p, -done, axis=0)]),
        u=np.vstack([led_u, up_u, np.roll(torques, -done, axis=0)]),
        travel=np.concatenate([np.ones(led, bool), np.roll(lap.travel, -done)]),
        again=led,
        done=done,
        ticks=led + lap.rows(laps) - done,
        kind=lap.kind,
        steps=bool(lap.steps),
    )


def checked(leg: Leg, lap: Lap) -> Leg:
    """`leg` itself. ParameterError with place and figure if any row that will be followed is beyond the limits."""
    _require_room(len(leg.p), lap.allowed.dt)
    if found := excess_of(leg, lap):
        raise ParameterError(f"{lap.name}: {found}")
    return leg


def excess_of(leg: Leg, lap: Lap) -> str | None:
    """Where and by how much the leg is beyond the limits, laps and end included; None where it is within."""
    for row in stretches(len(leg.p), leg.again, leg.ticks, lap.allowed.dt):
        found = worst(leg.p[row], leg.u[row], lap.allowed.shape, lap.allowed.dt, _steps(leg, lap, row))
        if found:
            return f"{place_of_row(leg.p, int(row[found.row]), lap.allowed.dt)}: {found}"
    return None


def _steps(leg: Leg, lap: Lap, row: Array) -> tuple[int, ...]:
    """Which of the rows `row` (k,) of a leg begin a declared step."""
    if not lap.steps:
        return ()
    declared = [leg.again + (step - leg.done) % len(lap.p) for step in lap.steps]
    return tuple(np.flatnonzero(np.isin(row, declared)).tolist())


def _require_room(rows: int, dt: float) -> None:
    room = REFERENCE_ROWS
    if rows > room:
        raise ParameterError(f"one lap and its approach take {rows * dt:.4g} s, the rig's memory holds {room * dt:g} s")
