"""The likeliest pose at rest of a body of which a few points are seen and no torque is known."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array

RODS = 4
"""Rods between two neighbouring places."""
SMOOTH, NEAR = 30.0, 1e3
"""Weights of the rest's curvature against its places, which it meets to a ten-thousandth of the length."""


class RestingBody(NamedTuple):
    """A body that bends in a plane, seen in its rest at m places along it, the base first."""

    places: Array
    """In the rest (m,2) [m]."""
    s: Array
    """Arc length of each (m,) [m]."""
    h: Array
    """Length of each rod (N,) [m]."""
    rest: Array
    """Its angle in the rest (N,) [rad]."""
    half: Array
    """Share of each hinge between rods in the bend of the proximal and of the distal half (N-1,2) [1]."""


class Scatter(NamedTuple):
    """Standard deviations before a point is seen."""

    bend: float
    """Of each half's even bend, by chambers or muscles [rad]."""
    unexplained: float
    """Of the bend that is none of them, over the whole length [rad]."""
    strain: float
    """Of the stretch of each half [1]."""
    point: float
    """Of a seen point [m]."""


def resting_body(places: Array, halves: int) -> RestingBody:
    """From its places in the rest (m,2) [m]; the distal half begins at the place `halves`."""
    chords = np.diff(places, axis=0)
    s = np.append(0.0, np.linalg.norm(chords, axis=1).cumsum())
    h = np.repeat(np.diff(s) / RODS, RODS)
    angles = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
    first = np.interp(h.cumsum() - h / 2, (s[1:] + s[:-1]) / 2, angles)

    def off(theta: Array) -> Array:
        misfit = (_points(h, theta)[::RODS] - places + places[0])[1:] / s[-1]
        return np.concatenate([NEAR * misfit.ravel(), SMOOTH * np.diff(theta, 2)])

    rest = least_squares(off, first).x
    at, width = h.cumsum()[:-1], (h[1:] + h[:-1]) / 2
    half = np.column_stack([at < s[halves], at >= s[halves]]) * width[:, None]
    return RestingBody(places, s, h, rest, half / half.sum(axis=0))


def estimated(body: RestingBody, seen: Sequence[int], points: Array, scatter: Scatter) -> tuple[Array, Array]:
    """Places (m,2) [m] and the bends of both halves (2,) [rad], from `points` (s,2) [m] of the places `seen`.

    The least of the elastic energy of what no actuation explains, of the actuation's own improbability, and of the
    misfit, which is what forces at the seen points would do: Gauss-Newton on the angles of all rods.
    """
    N, inner = body.h.size, np.diff(body.rest)
    width = (body.h[1:] + body.h[:-1]) / 2 / body.s[-1]
    hinge = 1.0 / (scatter.unexplained * np.sqrt(width))
    distal = np.append(body.half[:, 1] > 0.0, True)

    def places(x: Array) -> Array:
        return _points(body.h * (1.0 + np.where(distal, x[N + 3], x[N + 2])), x[:N])[::RODS]

    def off(x: Array) -> Array:
        unexplained = (np.diff(x[:N]) - inner - body.half @ x[N : N + 2]) * hinge
        misfit = (places(x)[list(seen)] - points).ravel() / scatter.point
        base = (x[0] - body.rest[0]) / (scatter.unexplained * np.sqrt(width[0]))
        return np.concatenate([unexplained, misfit, [base], x[N : N + 2] / scatter.bend, x[N + 2 :] / scatter.strain])

    starts = (np.zeros(2), _arcs(body, seen, points))
    begun = [np.concatenate([body.rest + np.append(0.0, (body.half @ u).cumsum()), u, np.zeros(2)]) for u in starts]
    found = min((least_squares(off, x) for x in begun), key=lambda one: float(one.cost)).x
    return places(found), found[N : N + 2]


def _arcs(body: RestingBody, seen: Sequence[int], points: Array) -> Array:
    """Bends of the halves (2,) [rad] by which chords to the first and the last seen place turn, as on two arcs.

    A body that is bent far has another pose on the other side of its chord, in which the search from rest may end.
    """
    here, rest = (np.diff(one[[0, -1]], axis=0, prepend=np.zeros((1, 2))) for one in (points, body.places[list(seen)]))
    turned = np.arctan2(here[:, 1], here[:, 0]) - np.arctan2(rest[:, 1], rest[:, 0])
    proximal, distal = (turned + np.pi) % (2.0 * np.pi) - np.pi
    return np.array([2.0 * proximal, 2.0 * (distal - 2.0 * proximal)])


def _points(h: Array, theta: Array) -> Array:
    """Base and end of every rod (N+1,2) [m]."""
    steps = h[:, None] * np.column_stack([np.cos(theta), np.sin(theta)])
    return np.vstack([np.zeros(2), steps.cumsum(axis=0)])
