"""Which points of a frame are handed on, and what they are called."""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from controller.arrays import Array
from controller.drivers.capture.natnet.definitions import Names
from controller.drivers.capture.natnet.packets import MODEL_FILLED, OCCLUDED, TRACKED, UNLABELLED, Frame, Malformed
from controller.drivers.device import POINTS_MAX

Wanted = Literal["labelled", "unlabelled", "rigid_bodies", "all"]

FILLED = 0.5
"""Quality of a marker that Motive placed by its model, unseen."""


class Point(NamedTuple):
    """One point of a frame; `at` is None where it is not seen."""

    label: str
    at: tuple[float, float, float] | None
    quality: float


class Naming:
    """Gives the markers of frames their names, and remembers them for markers that are covered."""

    def __init__(self, names: Names) -> None:
        self.names, self._sets = names, names.own_sets()
        self._known: dict[int, str] = {}

    def points(self, frame: Frame, wanted: Wanted) -> tuple[Array, tuple[str, ...], Array]:
        """Positions (M,3) [m] with nan for what is not seen, labels, quality (M,); raises Malformed.

        "labelled" has a row for each marker of a set that someone made, seen or not.
        """
        with np.errstate(invalid="ignore"):  # of signalling nan
            return self._points(frame, wanted)

    def _points(self, frame: Frame, wanted: Wanted) -> tuple[Array, tuple[str, ...], Array]:
        found: list[Point] = []
        if wanted in ("labelled", "all"):
            found += self._labelled(frame)
        if wanted in ("unlabelled", "all"):
            found += _unlabelled(frame)
        if wanted in ("rigid_bodies", "all"):
            taken = {point.label for point in found}
            found += [point for point in self._bodies(frame) if point.label not in taken]
        if len(found) > POINTS_MAX:
            raise Malformed(f"{len(found)} points, more than {POINTS_MAX}")
        rows = np.array([point.at or (np.nan,) * 3 for point in found], float).reshape(-1, 3)
        quality = np.array([point.quality for point in found], float)
        quality[np.isnan(rows).any(axis=1)] = 0.0
        return rows, tuple(point.label for point in found), quality

    def _labelled(self, frame: Frame) -> Iterator[Point]:
        in_sets = list(self._in_sets(frame))
        by_place = {point.at: point.label for point in in_sets if point.at is not None}
        told = set()
        for number, place, _, flags, _ in frame.labelled.tolist():
            if flags & UNLABELLED:
                continue
            at = tuple(place)
            label = by_place.get(at) or self.names.members.get((number >> 16, number & 0xFFFF)) or ""
            if label and len(self._known) < POINTS_MAX:
                self._known[number] = label
            if flags & OCCLUDED:
                label = label or self._known.get(number, "")
                if label and label not in told:
                    told.add(label)
                    yield Point(label, None, 0.0)
                continue
            label = label or f"{number >> 16}.{number & 0xFFFF}"
            told.add(label)
            yield Point(label, at, FILLED if flags & MODEL_FILLED else 1.0)
        yield from (point for point in in_sets if point.label not in told)

    def _in_sets(self, frame: Frame) -> Iterator[Point]:
        for name, places in frame.sets:
            labels = self._sets.get(name, ())
            if len(labels) == len(places):
                for label, place in zip(labels, places.tolist(), strict=True):
                    seen = any(place)  # Motive puts what it does not see at the origin
                    yield Point(label, tuple(place) if seen else None, float(seen))

    def _bodies(self, frame: Frame) -> Iterator[Point]:
        for number, place, _, _, flags in frame.bodies.tolist():
            seen = bool(flags & TRACKED)
            yield Point(self.names.bodies.get(number, str(number)), tuple(place) if seen else None, float(seen))


def _unlabelled(frame: Frame) -> Iterator[Point]:
    """Markers that belong to nothing: since 3.0 among the labelled ones, too, with a flag of their own."""
    taken = set()
    for _, place, _, flags, _ in frame.labelled.tolist():
        taken.add(tuple(place))
        if flags & UNLABELLED and not flags & OCCLUDED:
            yield Point("", tuple(place), 1.0)
    for place in frame.others.tolist():
        if tuple(place) not in taken:
            yield Point("", tuple(place), 1.0)
