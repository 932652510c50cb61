"""One lap of a reference, and the rows that lead the rig into it, from wherever its own reference is."""

from dataclasses import dataclass

import numpy as np

from controller.build_rig import REFERENCE_ROWS
from controller.errors import ParameterError
from controller.kernels.inverse import TOLERANCE, StaticMap
from controller.kernels.rod import Array
from controller.link import ENDLESS
from controller.parameters import RigParameters
from controller.reference import library
from controller.reference.approach import blended
from controller.reference.reach import static_tips
from controller.reference.reference import Reference
from controller.reference.within_reach import Carried, projected

APPROACH = 2000
"""Ticks from where the rig's reference is to the shape, and of the way back from its end to its start."""
SHORT_APPROACH = 500
"""Ticks back onto a path that was left within SHORT_WAY."""
SHORT_WAY = 10e-3
"""[m]"""
ON_GRID = 1e-6
"""So near to a tick a period ends on it [ticks]."""


@dataclass(frozen=True)
class Lap:
    """A reference as a run follows it, over and over."""

    name: str
    lead: Array
    """Rows (m, 2) [m] before the first lap only, as where the tip waits for the first of some steps."""
    p: Array
    """Rows (n, 2) [m] of one lap; the first comes after the last."""
    back: int
    """So many rows at its end are a way back to its start, which is left out after the last lap."""
    u: Array
    """Torques (2,) [N m] at the very first row."""
    frequency: tuple[float, float] | None
    """[Hz] of x and y where the laps are periodic."""

    def rows(self, laps: int | None) -> int:
        """How many rows so many laps have; None: without end."""
        return ENDLESS if laps is None else laps * len(self.p) - self.back


@dataclass(frozen=True)
class Leg:
    """What the rig is given for one stretch of a run: from its start, or from a pause, on."""

    p: Array
    """Rows (n, 2) [m]."""
    again: int
    """Row that comes after the last one: the first of the shape."""
    done: int
    """Rows of the shape that were followed in earlier legs."""
    ticks: int
    """Rows to follow in all."""

    def at(self, index: Array) -> Array:
        """Where the reference is at the rows `index` (k,) counted from the leg's first: (k, 2) [m]."""
        repeating = self.again + (index - self.again) % (len(self.p) - self.again)
        return self.p[np.where(index < len(self.p), index, repeating)]


@dataclass(frozen=True)
class Place:
    """Where a run was left."""

    done: int
    """Rows of the shape that were followed."""
    u: Array
    """Feedforward torques (2,) [N m] there."""


def lap_of(reference: Reference, rig: RigParameters, laps: int | None) -> Lap:
    """`reference` once, or closed if it is to be repeated: by its period, by its steps, or by a way back in u.

    Raises ParameterError if it does not fit the rig's memory.
    """
    smap = library.static_map(rig.actuator, rig.controller)
    begin = min(reference.start, round(library.APPROACH / rig.controller.dt))
    lead, shape = reference.p[begin : reference.start], reference.p[reference.start :]
    path = projected(smap, reference.p[begin:])
    period = period_rows(reference, len(shape), rig.controller.dt)
    way_back = np.empty((0, 2))
    if laps != 1 and period:
        shape = shape[:period]
    elif laps != 1 and not reference.steps:
        shape, way_back = closed(smap, shape, path)
    _require_room(APPROACH + len(lead) + len(shape) + len(way_back), rig.controller.dt)
    frequencies = None if len(way_back) else frequencies_of(reference)
    return Lap(reference.name, lead, np.vstack([shape, way_back]), len(way_back), path.u, frequencies)


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


def closed(smap: StaticMap, p: Array, path: Carried) -> tuple[Array, Array]:
    """The path p (n, 2) [m], and the way back from its end to its start, which are those of `path`."""
    if np.linalg.norm(p[-1] - p[0]) < TOLERANCE:
        return p[:-1], np.empty((0, 2))
    return p, blended(smap, path.u_end, path.u, APPROACH)[1:]


def first_leg(smap: StaticMap, lap: Lap, laps: int | None, u: Array) -> Leg:
    """From the torques u (2,) [N m] at which the rig is, through so many laps."""
    led = np.vstack([blended(smap, u, lap.u, APPROACH), lap.lead])
    return Leg(np.vstack([led, lap.p]), len(led), 0, len(led) + lap.rows(laps))


def next_leg(smap: StaticMap, lap: Lap, laps: int | None, u: Array, left: Place) -> Leg:
    """From the torques u (2,) [N m] at which the rig is back to where the path was left, and on to the end."""
    if not left.done:
        return first_leg(smap, lap, laps, u)
    apart = np.linalg.norm(static_tips(smap, u) - static_tips(smap, left.u))
    led = blended(smap, u, left.u, SHORT_APPROACH if apart < SHORT_WAY else APPROACH)
    onward = np.roll(lap.p, -left.done, axis=0)
    return Leg(np.vstack([led, onward]), len(led), left.done, len(led) + lap.rows(laps) - left.done)


def _require_room(rows: int, dt: float) -> None:
    room = REFERENCE_ROWS
    if rows > room:
        raise ParameterError(f"one lap and its approach take {rows * dt:.4g} s, the rig's memory holds {room * dt:g} s")
