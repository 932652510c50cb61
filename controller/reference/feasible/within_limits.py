"""A path as the rig may follow it: within reach and limits, retimed where it is too fast, led round where it tears.

Where a path can only go on in another pose of the arm (a hole in the reach, a branch that ends), its pieces are joined
by travel through u. What is within the limits as it is keeps every row.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import scratch_for
from controller.errors import ParameterError
from controller.kernels.control.along import refine_each
from controller.kernels.control.inverse import REFINE_STEPS, TOLERANCE
from controller.kernels.control.retime import fastest_progress
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.bounds import Limits, exceeding, place_of_row, standing, window_rows, worst
from controller.reference.feasible.reach import static_tips
from controller.reference.feasible.smoothing import continued
from controller.reference.feasible.travel import Pose, joined
from controller.reference.feasible.within_reach import Carried, projected
from controller.reference.shapes import lengths

SPACING = 1e-4
"""From point to point of what is retimed [m]."""
POINTS_MAX = 200_000
"""More points than these are not made: a path so long is retimed coarsely."""
TORN = 3e-3
"""A path whose nearest points in reach are further apart than this, from one of its own to the next, is torn [m]."""
TORN_TORQUE = 0.1
"""So is one whose torques are, as a share of the largest."""
PIECE_MIN = 9
"""Points of the shortest piece."""
LEVER = 0.5
"""What a torque turns counts as a step of this many times that [m/(N m)]; the arm's own is some ten times it."""
FINE_TORQUE, FINE_MAX = 2e-3, 100
"""Torques of neighbouring points differ by no more, as a share of the largest; points that are put between two."""
SHARP = 0.7
"""Cosine of a turn from one point to the next, beyond which it is a corner: all of it is passed in one step."""
CALMING = (0.01, 0.02, 0.04)
"""Half-widths of the hats in time by which noise is taken off a sampled path [s]."""
NOISE = 5e-4
"""No point is moved further by it [m]."""
ROUNDS_MAX, TIGHTER, ALMOST = 30, 0.9, 0.999
BRAKE, NEAR = 0.6, 0.03
"""How much slower a piece goes where it exceeds a limit, and so long before and after that place [s]."""
CRAWL = 1.0
"""Where rounding leaves no progress at all, this many points a second are made."""
DETOUR_POINTS, AT_ONCE = 5000, 1e-6
"""Of a detour, and the time from one to the next that is wished [s]: as fast as the limits allow."""
TRAVEL_RATE = 0.1
"""Torques travel at this share of the torque rate that a path may ask for, as at a change of branch in FOLLOW."""


@dataclass(frozen=True)
class Followed:
    """What is followed of a path, one row a tick."""

    p: Array
    """(n, 2) [m]."""
    u: Array
    """(n, 2) torques that hold them [N m]."""
    wished: Array
    """(n, 2) [m] the path's own points; on travel the one where it was left."""
    distance: Array
    """(n,) [m] from there to the reach; 0 within it and on travel."""
    travel: np.ndarray
    """(n,) of bool: rows that lead from one piece of the path to the next."""
    said: tuple[str, ...] = ()
    """What was changed, in words."""


def within_limits(smap: StaticMap, wished: Array, limits: Limits, dt: float, sampled: bool = False) -> Followed:
    """The path `wished` (n, 2) [m] from rest to rest, as near to its own timing as `limits` allow.

    `sampled`: its points were measured, so that noise may be taken off. Raises ParameterError with place and figure
    where no timing keeps within the limits.
    """
    as_is = carried_rows(projected(smap, wished), wished)
    if fits(as_is, limits, dt):
        return as_is
    calm = calmed(smap, wished, limits, dt) if sampled else None
    return calm or retimed(smap, wished, limits, dt)


def carried_rows(path: Carried, wished: Array) -> Followed:
    """A path whose rows all are its own."""
    return Followed(path.p, path.u, wished, path.distance, np.zeros(len(wished), bool))


def fits(path: Followed, limits: Limits, dt: float) -> bool:
    """Whether all of it is within the limits, from rest to rest."""
    return worst(standing(path.p, dt), standing(path.u, dt), limits, dt) is None


def calmed(smap: StaticMap, wished: Array, limits: Limits, dt: float) -> Followed | None:
    """The path without the noise of its samples; None where that is not what exceeds the limits."""
    for half in CALMING:
        reach = round(half / dt)
        if len(wished) <= 2 * reach:
            return None
        hat = 1.0 - np.abs(np.arange(1 - reach, reach)) / reach
        longer = continued(wished, reach - 1, closed=False)
        smooth = np.column_stack([np.convolve(longer[:, j], hat / hat.sum(), "valid") for j in range(2)])
        moved = float(np.hypot(*(smooth - wished).T).max())
        if moved > NOISE:
            return None
        found = carried_rows(projected(smap, smooth), wished)
        if fits(found, limits, dt):
            text = f"smoothed over {2e3 * half:g} ms (moved by up to {1e3 * moved:.2g} mm), as its samples are noisy"
            return replace(found, said=(text,))
    return None


@dataclass(frozen=True)
class Points:
    """A path as points, not as rows."""

    path: Carried
    wished: Array
    """(n, 2) [m]."""
    t: Any
    """(n,) when it is to be there [s], rising."""

    def part(self, first: int, end: int) -> "Points":
        """Points from `first` up to `end`, evenly along the piece that they are."""
        return self.at(first + even(*(steps[first : end - 1] for steps in steps_of(self.path))))

    def at(self, at: Any) -> "Points":
        """What is at the places `at` (k,) [points, not whole], along straight lines."""
        path = self.path
        return Points(
            Carried(between(path.u, at), between(path.p, at), between(path.distance, at), ()),
            between(self.wished, at),
            between(self.t, at),
        )


def even(step: Array, turn: Array) -> Any:
    """Places (k,) [points, not whole] that are evenly apart, given the `step` [m] and `turn` [N m] between points.

    A turn counts a little, too: where the tip stands, at a fold, the torques still move.
    """
    way = np.concatenate([[0.0], np.cumsum(step + LEVER * turn)])
    count = int(np.clip(np.ceil(way[-1] / SPACING), PIECE_MIN, POINTS_MAX))
    return np.interp(np.linspace(0.0, way[-1], count + 1), way, np.arange(len(way)))


def between(values: Array, at: Any) -> Array:
    """`values` (n,) or (n, 2) at the places `at` (k,) [rows, not whole], along straight lines."""
    lower = np.clip(at.astype(int), 0, len(values) - 1)
    upper = np.minimum(lower + 1, len(values) - 1)
    share = (at - lower).reshape(-1, *(1,) * (values.ndim - 1))
    found: Array = values[lower] + share * (values[upper] - values[lower])
    return found


def retimed(smap: StaticMap, wished: Array, limits: Limits, dt: float) -> Followed:
    """The path in its pieces, each slowed where it is too fast, with travel between them."""
    points = spaced(smap, wished, dt)
    cuts = [0, *tears(smap, points.path), len(points.t)]
    parts = [points.part(first, end) for first, end in pairwise(cuts)]
    waits = wait_rows(wished)
    pieces = [slowed(smap, part, limits, dt) for part in parts]
    rows: list[Followed] = [held(pieces[0], 0, waits[0]), pieces[0]]
    said: list[str] = []
    for before, piece in pairwise(pieces):
        rows.append(detour(smap, before, piece, limits, dt))
        said.append(detour_text(rows, dt))
        rows.append(piece)
    rows.append(held(pieces[-1], -1, waits[1]))
    found = together(rows)
    if excess := worst(standing(found.p, dt), standing(found.u, dt), limits, dt):
        at = min(max(0, excess.row - window_rows(dt)), len(found.p) - 1)
        raise ParameterError(f"no timing keeps it within limits: {place_of_row(found.p, at, dt)}: {excess}")
    moving = (len(found.p) - 1 - int(found.travel.sum())) * dt
    if moving > (len(wished) - 1) * dt + 0.01:
        said.insert(0, retimed_text((len(wished) - 1) * dt, moving, limits))
    return replace(found, said=tuple(said))


def retimed_text(before: float, after: float, limits: Limits) -> str:
    """From how long to how long."""
    return (
        f"retimed from {before:.4g} s to {after:.4g} s, to keep within {1e3 * limits.speed:g} mm/s, "
        f"{limits.acceleration:g} m/s^2 and {limits.torque_rate:g} N m/s"
    )


def detour_text(rows: list[Followed], dt: float) -> str:
    """Where the travel that `rows` end with is, and how long."""
    start = sum(len(part.p) for part in rows[:-1])
    p = rows[-1].p
    length, seconds = 1e3 * float(lengths(p)[-1]), len(p) * dt
    x, y = 1e3 * p[0]
    where = f"({x:.0f}, {y:.0f}) mm, where it can only go on in another pose of the arm"
    return f"detour of {length:.0f} mm in {seconds:.2g} s at {start * dt:.3g} s, {where}"


def spaced(smap: StaticMap, wished: Array, dt: float) -> Points:
    """The path at even distances along itself, and when it is to be there; without the waits at its ends."""
    s = lengths(wished)
    count = int(min(POINTS_MAX, max(PIECE_MIN, np.ceil(s[-1] / SPACING))))
    at = np.linspace(0.0, s[-1], count + 1)
    row = np.asarray(np.interp(at, s, np.arange(len(wished))), np.float64)
    first, last = wait_rows(wished)
    row[0], row[-1] = first, len(wished) - 1 - last
    p = np.column_stack([np.interp(at, s, wished[:, j]) for j in range(2)])
    return fine(smap, Points(projected(smap, p), p, dt * row))


def fine(smap: StaticMap, points: Points) -> Points:
    """The same with more points through u where their nearest ones in reach are far apart, unless it is torn there."""
    path, largest = points.path, smap.polygon.bounds[0]
    step, turn = steps_of(path)
    count = np.maximum(np.ceil(step / (2.0 * SPACING)), np.ceil(turn / (FINE_TORQUE * largest)))
    count = np.clip(count, 1, FINE_MAX).astype(int)
    count[torn(smap, path)] = 1
    if (count == 1).all():
        return points
    lower = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(count) - count
    at = np.append(lower + (np.arange(len(lower)) - first[lower]) / count[lower], float(len(count)))
    found = points.at(at)
    found.path.p[at != np.floor(at)] = static_tips(smap, found.path.u)[at != np.floor(at)]
    return found


def wait_rows(wished: Array) -> tuple[int, int]:
    """For how many rows the path stands still before it moves, and after."""
    moving = np.flatnonzero((np.diff(wished, axis=0) != 0.0).any(axis=1))
    return int(moving[0]), len(wished) - 2 - int(moving[-1])


def tears(smap: StaticMap, path: Carried) -> list[int]:
    """Points before which the path is torn: its pose of the arm is another one."""
    return [int(row) + 1 for row in np.flatnonzero(torn(smap, path))]


def torn(smap: StaticMap, path: Carried) -> np.ndarray:
    """Whether the path is torn between each point and the next, (n - 1,) of bool."""
    step, turn = steps_of(path)
    found: np.ndarray = (step > max(TORN, 20.0 * float(np.median(step)))) | (
        turn > TORN_TORQUE * smap.polygon.bounds[0]
    )
    return found


def steps_of(path: Carried) -> tuple[Array, Array]:
    """How far it is from each point to the next, (n - 1,) [m], and how far for the torques [N m]."""
    return np.hypot(*np.diff(path.p, axis=0).T), np.abs(np.diff(path.u, axis=0)).max(axis=1)


def held(piece: Followed, at: int, rows: int) -> Followed:
    """The row `at` of a piece for this many rows."""
    p, u, wished = (np.tile(a[at], (rows, 1)) for a in (piece.p, piece.u, piece.wished))
    return Followed(p, u, wished, np.full(rows, piece.distance[at]), np.zeros(rows, bool))


def detour(smap: StaticMap, before: Followed, after: Followed, limits: Limits, dt: float) -> Followed:
    """The travel from the end of one piece to the start of the next."""
    gentle = limits._replace(torque_rate=TRAVEL_RATE * limits.torque_rate)
    start, end = Pose(before.p[-1], before.u[-1]), Pose(after.p[0], after.u[0])
    u = start.u + np.linspace(0.0, 1.0, DETOUR_POINTS)[:, None] * (end.u - start.u)
    way = Carried(u, static_tips(smap, u), np.zeros(DETOUR_POINTS), ())
    points = Points(way, way.p, AT_ONCE * np.arange(DETOUR_POINTS))
    found = slowed(smap, points.part(0, DETOUR_POINTS), gentle, dt)
    p, u = joined(start, (found.p, found.u), end, dt)
    rows = len(p)
    return Followed(p, u, np.tile(before.wished[-1], (rows, 1)), np.zeros(rows), np.ones(rows, bool))


def together(rows: list[Followed]) -> Followed:
    """One after the other."""
    return Followed(
        p=np.concatenate([part.p for part in rows]),
        u=np.concatenate([part.u for part in rows]),
        wished=np.concatenate([part.wished for part in rows]),
        distance=np.concatenate([part.distance for part in rows]),
        travel=np.concatenate([part.travel for part in rows]),
    )


def slowed(smap: StaticMap, part: Points, limits: Limits, dt: float) -> Followed:
    """A piece from rest to rest, nowhere faster than it was, within `limits`; ParameterError where there is no way.

    Corners that the points do not resolve are passed more slowly until the rows are within the limits: no speed below
    half the acceleration's limit times its window can exceed it.
    """
    tight = limits.scaled(ALMOST)._replace(acceleration=TIGHTER * limits.acceleration)
    brake = np.ones(len(part.t))
    for _ in range(ROUNDS_MAX):
        progress = progress_times(part, tight, brake)
        found = sampled_rows(smap, part, progress, dt)
        rows = exceeding(standing(found.p, dt), standing(found.u, dt), limits, dt) - window_rows(dt)
        if not rows.size:
            return found
        brake[near(progress[1], rows * (progress[1][-1] / max(1, len(found.p) - 1)), NEAR)] *= BRAKE
    excess = worst(standing(found.p, dt), standing(found.u, dt), limits, dt)
    at = place_of_row(found.p, int(np.clip(rows[0], 0, len(found.p) - 1)), dt)
    raise ParameterError(f"no timing keeps it within limits: {at}: {excess}")


def near(t: Array, places: Array, apart: float) -> np.ndarray:
    """Which of the rising t (n,) [s] are within `apart` of one of the rising `places` (k,) [s]."""
    found: np.ndarray = np.searchsorted(places, t + apart, "right") > np.searchsorted(places, t - apart)
    return found


def progress_times(part: Points, limits: Limits, brake: Array) -> tuple[Array, Array]:
    """Progress x (n,) [1/s^2] along the points, and when each is reached t (n,) [s]; `brake` (n,) times as fast."""
    p, u, t = np.ascontiguousarray(part.path.p), part.path.u, part.t
    steps = np.diff(p, axis=0)
    way = np.maximum(np.hypot(*steps.T), 1e-12)
    turn = np.maximum(np.abs(np.diff(u, axis=0)).max(axis=1), 1e-15)
    rate = np.minimum(np.minimum(limits.speed / way, limits.torque_rate / turn), 1.0 / np.maximum(np.diff(t), 1e-9))
    most = np.minimum(np.append(np.inf, rate), np.append(rate, np.inf)) ** 2
    first = np.gradient(p, axis=0)
    second = np.zeros_like(p)
    second[1:-1] = p[2:] - 2.0 * p[1:-1] + p[:-2]
    sharp = 1 + np.flatnonzero((steps[1:] * steps[:-1]).sum(axis=1) < SHARP * way[1:] * way[:-1])
    turned = np.maximum(np.hypot(*second[sharp].T), 1e-12)
    most[sharp] = np.minimum(most[sharp], 0.5 * limits.acceleration / turned)
    most *= brake**2
    x = np.empty(len(p))
    fastest_progress(first, second, most, limits.acceleration, x)
    inner = slice(1, -1)
    x[inner] = np.maximum(x[inner], np.minimum(CRAWL**2, most[inner]))
    return x, np.concatenate([[0.0], np.cumsum(2.0 / (np.sqrt(x[1:]) + np.sqrt(x[:-1])))])


def sampled_rows(smap: StaticMap, part: Points, progress: tuple[Array, Array], dt: float) -> Followed:
    """Rows every dt [s], slowed a little so that the last point falls on one."""
    x, t = progress
    at = np.linspace(0.0, t[-1], int(np.ceil(t[-1] / dt - 1e-9)) + 1)
    i = np.clip(np.searchsorted(t, at, "right") - 1, 0, len(t) - 2)
    tau = at - t[i]
    along = i + np.clip(np.sqrt(x[i]) * tau + 0.25 * (x[i + 1] - x[i]) * tau**2, 0.0, 1.0)
    p, u = between(part.path.p, along), between(part.path.u, along)
    refine_each(smap, REFINE_STEPS, p, u, scratch_for(smap))
    wished = between(part.wished, along)
    off = np.hypot(*(wished - p).T)
    return Followed(p, u, wished, np.where(off >= TOLERANCE, off, 0.0), np.zeros(len(at), bool))
