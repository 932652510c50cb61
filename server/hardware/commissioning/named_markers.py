"""Whether every marker with a name lies where the rod that `labels` gives it does: names are held against geometry."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from server.hardware.commissioning.messages import Number

OFF_MAX = 0.1
"""A marker is glued this far from its rod at most, as a share of the actuator's length."""


class Rest(NamedTuple):
    """What was seen of the arm at rest, in the camera's coordinates (3,) each."""

    base: Array
    tip: Array
    named: Mapping[str, Array]
    """Markers that have a name."""


class Placed(NamedTuple):
    """A marker with a name, beside the model's arm."""

    name: str
    rod: int
    """That `labels` give it."""
    nearest: int
    """Rod that lies nearest to it."""
    off: float
    """Way to its own rod [m]."""


def placed(rest: Rest, rods: Array, labels: Mapping[str, int], scale: float) -> list[Placed]:
    """Each marker of `labels` that was seen, beside the `rods` (10,2) [m] of the model's arm, `scale` times as long.

    By its place along the line from base to tip, and off it: which way the plane is turned is not known yet.
    """
    tip = rods[-1]
    model = scale * _along_and_off(np.column_stack((rods, np.zeros(len(rods)))), np.array([*tip, 0.0]))
    found = []
    for name, rod in labels.items():
        if (at := rest.named.get(name)) is None:
            continue
        ways = np.linalg.norm(model - _along_and_off((at - rest.base)[None], rest.tip - rest.base), axis=1)
        found.append(Placed(name, rod, int(np.argmin(ways)) + 1, float(ways[rod - 1])))
    return found


def swapped(found: Sequence[Placed]) -> str:
    """Which two labels are swapped; "" where none are."""
    for a, b in combinations(found, 2):
        if a.rod != b.rod and (a.nearest, b.nearest) == (b.rod, a.rod):
            return f"labels {a.name} and {b.name} are swapped: {_lies(a)}, {_lies(b)}"
    return ""


def misplaced(found: Sequence[Placed], labels: Mapping[str, int], length: float) -> str:
    """What is wrong with where the markers lie, for an arm of `length` [m]; "" where nothing is."""
    faults = [f"{name} (rod {rod}) was not seen at rest" for name, rod in labels.items() if name not in _names(found)]
    for one in found:
        if one.nearest != one.rod:
            faults.append(f"{_lies(one)}, and labels say rod {one.rod}")
        elif one.off > OFF_MAX * length:
            faults.append(f"{one.name} lies {one.off * 1e3:.0f} mm from rod {one.rod}, which labels say")
    return "; ".join(faults)


def numbers(found: Sequence[Placed], length: float) -> list[Number]:
    """How far each lies from its rod."""
    most = OFF_MAX * length
    bound = f"at most {most:.3g} m, and no other rod nearer"
    return [
        Number(
            name=f"{one.name}, from rod {one.rod}",
            value=one.off,
            unit="m",
            bound=bound,
            kept=one.nearest == one.rod and one.off <= most,
        )
        for one in found
    ]


def _along_and_off(points: Array, way: Array) -> Array:
    """Of `points` (M,3) from the base: along `way` (3,), and off it, (M,2)."""
    along = points @ (way / np.linalg.norm(way))
    return np.column_stack((along, np.sqrt(np.maximum(0.0, (points**2).sum(axis=1) - along**2))))


def _names(found: Sequence[Placed]) -> set[str]:
    return {one.name for one in found}


def _lies(one: Placed) -> str:
    return f"{one.name} lies at rod {one.nearest}"
