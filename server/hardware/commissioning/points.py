"""Points that motion capture sees, in its own coordinates: which one is meant, and where it was over a moment."""

import asyncio
from collections.abc import Callable, Sequence

import numpy as np

from controller.arrays import Array
from controller.errors import CommandRefused
from controller.schema.hardware import Drivers
from server.hardware.commissioning.messages import CaptureBody, Captured, Place, PointName

WINDOW_S, SAMPLE_S = 0.5, 0.02
"""Over which the median of a point is taken, and how often it is looked at [s]."""
SAMPLES_LEAST = 5
UNSEEN_S = 1.0
"""Longest wait for a point that is followed and not seen [s]."""
SPREAD_MAX = 2e-3
"""Standard deviation of a captured point [m]: beyond, it was moved."""
Points = dict[str, Array]
"""By name, (3,) each."""
See = Callable[[], Drivers]
"""How the rig's devices fare; it waits for the rig's answer."""


def points_in(found: Drivers) -> Points:
    """What motion capture sees now; CommandRefused without a motion capture that gives points."""
    capture = next((one for one in found.drivers if one.role == "motion_capture"), None)
    if capture is None:
        raise CommandRefused("the rig has no motion capture: its plant is simulated")
    if capture.state != "running":
        raise CommandRefused(f"motion capture ({capture.driver}) is {capture.state}: {capture.detail}")
    places = {}
    for name, values in capture.values.items():
        if len(values) in (2, 3) and all(value is not None for value in values):
            places[name] = np.array([*(value or 0.0 for value in values), 0.0][:3])
    return places


async def watched(see: See) -> list[Points]:
    """What is seen over WINDOW_S, one look after another; CommandRefused likewise."""
    loop, looks = asyncio.get_running_loop(), list[Points]()
    end = loop.time() + WINDOW_S
    while loop.time() < end:
        looks.append(points_in(await asyncio.to_thread(see)))
        await asyncio.sleep(SAMPLE_S)
    return looks


async def followed(see: See, name: PointName | None, near: Array) -> Array:
    """Where the point that was at `near` (3,) is now (3,); CommandRefused where it is not seen for UNSEEN_S."""
    loop = asyncio.get_running_loop()
    end = loop.time() + UNSEEN_S
    while (found := _nearest(points_in(await asyncio.to_thread(see)), name, near)) is None:
        if loop.time() > end:
            raise CommandRefused(f"the point {name} was not seen for {UNSEEN_S:g} s while it moved")
        await asyncio.sleep(SAMPLE_S)
    return found


def captured(body: CaptureBody, looks: Sequence[Points], near: Array | None = None) -> Captured:
    """The point that is meant, by name, or the one nearest to where it was last, `near` (3,); its median.

    CommandRefused where it is not clear which is meant, or it was hardly seen.
    """
    name, seen = body.point, list[Array]()
    if near is None:
        name = _chosen(looks[0], name)
        near = looks[0][name]
    for points in looks:
        one = _nearest(points, name, near)
        if one is not None:
            seen.append(one)
            near = one
    return median(body.place, name or "", seen)


def median(place: Place, name: str, seen: Sequence[Array]) -> Captured:
    """Of what was seen (3,); CommandRefused where that is too little."""
    if len(seen) < SAMPLES_LEAST:
        bound = f"at least {SAMPLES_LEAST}"
        raise CommandRefused(f"{place}: the point was seen {len(seen)} times in {WINDOW_S:g} s, {bound}")
    at = np.median(seen, axis=0)
    spread = float(np.sqrt(((np.array(seen) - at) ** 2).sum(axis=1).mean()))
    return Captured(place=place, point=name, at=[float(value) for value in at], spread=spread)


def require_still(point: Captured) -> None:
    """Raise CommandRefused where it was moved.

    To be asked once its unit is known to be the metre: 0.1 mm of noise are 0.1 of a camera that measures in mm.
    """
    if point.spread > SPREAD_MAX:
        bound = f"at most {SPREAD_MAX:g} m: hold it still, and capture it again"
        raise CommandRefused(f"{point.place}: the point moved by {point.spread:.4g} m (rms), {bound}")


def _nearest(points: Points, name: PointName | None, near: Array) -> Array | None:
    """The point of this name; of those without one, whose numbers may change, the nearest to where it was."""
    if name is not None and not name.startswith("#"):
        return points.get(name)
    return min(points.values(), key=lambda at: float(np.linalg.norm(at - near)), default=None)


def _chosen(points: Points, name: PointName | None) -> PointName:
    """The name of the point that is meant; CommandRefused where that is not clear."""
    if name is None and len(points) == 1:
        return next(iter(points))
    if name is None or name not in points:
        asked = "no point is named" if name is None else f"there is no point {name}"
        raise CommandRefused(f"{asked}: motion capture sees {', '.join(points) or 'none'}")
    return name
