"""From the bending stiffness EI along the arc length to the joints of a chain of rods."""

from collections.abc import Sequence

import numpy as np

from controller.arrays import Array

PARALLEL = 1e-6
"""Ends of a piece whose EI differ by less than this share are a uniform piece: the logarithm loses its digits."""


def joint_stiffness(EI: Sequence[float], arc: Sequence[float], length: float, rods: int) -> Array:
    """Stiffness (rods,) [N m/rad] of the joints of equal rods on a backbone with EI [N m^2] at the arc lengths [m].

    A joint has the compliance of the backbone between the middles of the rods it joins, the base joint that from the
    clamp to the first middle: the chain's statics are then of order 2 in the length of a rod. EI is linear between the
    values, and constant beyond them; one value is uniform.
    """
    edges = np.concatenate([[0.0], (np.arange(rods) + 0.5) / rods * length])
    known, at = np.asarray(EI, dtype=float), _places(len(EI), arc, length)
    cuts = np.unique(np.concatenate([edges, at[(at > 0.0) & (at < edges[-1])]]))
    values = np.interp(cuts, at, known)
    total = np.concatenate([[0.0], np.cumsum(_compliance(np.diff(cuts), values[:-1], values[1:]))])
    return np.asarray(1.0 / np.diff(np.interp(edges, cuts, total)))


def _places(count: int, arc: Sequence[float], length: float) -> Array:
    """Arc lengths (count,) [m] of the values: as they are given, else even from base to tip."""
    return np.array(arc) if arc else np.linspace(0.0, length, count)


def _compliance(ds: Array, first: Array, last: Array) -> Array:
    """Integral of ds / EI over pieces (n,) [m] on which EI goes in a line from `first` to `last` (n,)."""
    change = (last - first) / first
    even = np.abs(change) < PARALLEL
    return np.asarray(ds / first * np.where(even, 1.0 - change / 2, np.log1p(change) / np.where(even, 1.0, change)))
