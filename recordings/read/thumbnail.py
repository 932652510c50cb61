"""The picture of a recording in the list: its path in a few hundred bytes, kept in its description."""

import numpy as np

from controller.arrays import Array
from recordings.read.course import run_clock
from recordings.read.quick import Quick

SIZE = 100
"""Of the box, in both directions."""
POINTS = 64
SPAN_MIN = 0.01
"""A smaller path is drawn as if it were this large [m]: the noise of a tip at rest is no shape."""


def thumbnail(look: Quick) -> str:
    """Where the tip was measured in the run, of a periodic one in the last period: SVG path data, y down.

    "" where it was seen nowhere.
    """
    points = _points(look)
    if not len(points):
        return ""
    low, high = points.min(axis=0), points.max(axis=0)
    scale = SIZE / max(float((high - low).max()), SPAN_MIN)
    at = np.rint((points - (low + high) / 2) * (scale, -scale) + SIZE / 2).astype(int)
    steps = np.diff(at, axis=0)
    rest = " ".join(f"{dx} {dy}" for dx, dy in steps[steps.any(axis=1)])
    return f"M{at[0][0]} {at[0][1]}" + (f"l{rest}" if rest else "")


def _points(look: Quick) -> Array:
    """(k, 2) [m], at most POINTS."""
    track = next((track for track in look.tracks if track.field == "p_meas"), None)
    if track is None:
        return np.empty((0, 2))
    t = np.array(look.track_t)
    points = np.array([track.x, track.y], np.float64).T
    shown = np.isfinite(points).all(axis=1) & np.isfinite(run_clock(t, look.stretches))
    if look.period is not None:
        shown &= (t > look.cycle_end - look.period) & (t <= look.cycle_end)
    found = points[shown]
    return np.asarray(found[np.linspace(0, len(found) - 1, min(len(found), POINTS)).astype(int)])
