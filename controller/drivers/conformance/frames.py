"""Checks of what comes: in time, fresh, in our units, and nothing that is not a number."""

import math
import time
from typing import Any

import numpy as np

from controller.drivers.conformance.bench import RADIUS
from controller.drivers.conformance.trial import Failed, Trial, require
from controller.drivers.device import Angles, Reading, Sample

SPAN = 0.5
"""For so long frames are watched [s]."""
AGE_MAX = 0.5
"""A frame that is older when it comes counts as stale [s]."""
FAR = 100.0
"""No marker is seen beyond this [m]."""
PRESSURE_LEAST, PRESSURE_MOST = -110e3, 2e6
"""No gauge pressure is outside this [Pa]."""


def keeps_to_its_time(trial: Trial) -> str:
    """Calls come back within their timeout, and frames do come."""
    with trial.opened() as device:
        trial.first(device)
        longest, calls, came = 0.0, 0, 0
        until = time.monotonic() + SPAN
        while time.monotonic() < until:
            begun = time.monotonic()
            came += trial.call(device) is not None
            longest, calls = max(longest, time.monotonic() - begun), calls + 1
            time.sleep(max(0.0, begun + trial.kind.period - time.monotonic()))
        require(came >= 0.5 * calls, f"of {calls} calls only {came} gave a frame")
        return f"{came / SPAN:.0f} frames/s, longest call {1e3 * longest:.0f} ms"


def is_fresh(trial: Trial) -> str:
    """Times of capture are on our clock: never in the future, never backwards, not old, not always the same."""
    ages: list[float] = []
    times: list[int] = []
    with trial.opened() as device:
        trial.first(device)
        until = time.monotonic() + SPAN
        while time.monotonic() < until:
            frame = trial.call(device)
            now = time.monotonic_ns()
            if frame is None:
                continue
            require(type(frame.t_ns) is int, f"t_ns is a {type(frame.t_ns).__name__}, not an int")
            require(
                frame.t_ns <= now, f"t_ns is {(frame.t_ns - now) * 1e-9:.3f} s in the future of our monotonic clock"
            )
            require(not times or frame.t_ns >= times[-1], "t_ns goes back")
            times.append(frame.t_ns)
            ages.append((now - frame.t_ns) * 1e-9)
            time.sleep(trial.kind.period)
    require(bool(times), "nothing came")
    oldest = max(ages)
    require(oldest <= AGE_MAX, f"a frame was {oldest:.2f} s old when it came")
    require(
        len(set(times)) > len(times) // 2, f"of {len(times)} frames only {len(set(times))} have a time of their own"
    )
    return f"median age {1e3 * sorted(ages)[len(ages) // 2]:.1f} ms, oldest {1e3 * oldest:.1f} ms"


def is_well_formed(trial: Trial) -> str:
    """Shapes and numbers are as the protocol has them; nan only where something is not seen or broken."""
    seen: set[str] = set()
    with trial.opened() as device:
        trial.first(device)
        for _ in range(100):
            frame = trial.call(device)
            if frame is not None:
                CHECKS.get(type(frame), _unknown)(frame)
                seen.add(type(frame).__name__)
    require(bool(seen), "nothing came")
    return " and ".join(sorted(seen))


def shows_metres(trial: Trial) -> str:
    """A marker at a known distance is seen there."""
    nearest = math.inf
    with trial.opened() as device:
        trial.first(device)
        for _ in range(50):
            frame = trial.call(device)
            if not isinstance(frame, Sample) or len(frame.points) == 0:
                continue
            distance = np.linalg.norm(frame.points, axis=1)
            if trial.bench is None:
                return f"a marker {np.nanmin(distance):.3f} m from the origin: compare it with a ruler"
            nearest = min(nearest, float(np.nanmin(np.abs(distance - RADIUS))))
    require(
        nearest < 0.005, f"a marker {RADIUS} m from the origin is seen {nearest:.3g} m from there: are these metres?"
    )
    return f"right by {1e3 * nearest:.2f} mm"


def _check_reading(frame: Reading) -> None:
    values = _numbers("pressures", frame.pressures)
    require(values.shape == (4,), f"pressures have the shape {values.shape}, not (4,)")
    require(not np.isinf(values).any(), "a pressure is infinite: nan is what a broken sensor says")
    likely = values[np.isfinite(values)]
    inside = bool(((likely >= PRESSURE_LEAST) & (likely <= PRESSURE_MOST)).all())
    require(inside, f"pressures {likely.round()} Pa are none of a gauge in this world")
    require(isinstance(frame.stopped, str), "stopped is no text")


def _check_sample(frame: Sample) -> None:
    points = _numbers("points", frame.points)
    require(points.ndim == 2 and points.shape[1] in (2, 3), f"points have the shape {points.shape}, not (M,2) or (M,3)")
    whole = np.isfinite(points).all(axis=1) | np.isnan(points).all(axis=1)
    require(bool(whole.all()), "a point is neither wholly numbers nor wholly nan")
    require(not (np.abs(points) > FAR).any(), f"a point is more than {FAR:g} m away")
    require(len(frame.labels) in (0, len(points)), f"{len(frame.labels)} labels for {len(points)} points")
    if frame.quality is not None:
        quality = _numbers("quality", frame.quality)
        require(quality.shape == (len(points),), f"quality has the shape {quality.shape}")
        require(bool(((quality >= 0.0) & (quality <= 1.0)).all()), "quality is outside [0, 1]")


def _check_angles(frame: Angles) -> None:
    arcs, angles = _numbers("arcs", frame.arcs), _numbers("angles", frame.angles)
    require(arcs.ndim == 1 and arcs.shape == angles.shape, "arcs and angles are not (K,)")
    require(bool(np.isfinite(arcs).all() and (np.diff(arcs) > 0.0).all()), "arcs do not rise")
    require(not np.isinf(angles).any(), "an angle is infinite")


def _unknown(frame: Any) -> None:
    raise Failed(f"a {type(frame).__name__} is no Reading, Sample or Angles")


CHECKS: dict[type, Any] = {Reading: _check_reading, Sample: _check_sample, Angles: _check_angles}


def _numbers(name: str, values: Any) -> Any:
    require(isinstance(values, np.ndarray), f"{name} is a {type(values).__name__}, not an array")
    require(values.dtype == np.float64, f"{name} holds {values.dtype}, not float64")
    return values
