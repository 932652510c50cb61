"""Checks of what comes: in time, fresh, in our units, and nothing that is not a number."""

import math
import time
from typing import Any

import numpy as np

from controller.drivers.conformance.bench import RADIUS
from controller.drivers.conformance.trial import Failed, NotShown, Trial, require
from controller.drivers.device import Angles, Reading, Sample

SPAN = 0.5
"""For so long frames are watched [s]."""
AGE_MAX = 0.5
"""A frame that is older when it comes counts as stale [s]."""
FRAMES, MARKERS = 100, 50
"""That are looked at."""
CHAMBERS = ("u1+", "u1-", "u2+", "u2-")
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
    frames: list[Any] = []
    with trial.opened() as device:
        trial.first(device)
        for _ in range(FRAMES):
            frame = trial.call(device)
            if frame is not None:
                CHECKS.get(type(frame), _unknown)(frame)
                frames.append(frame)
    require(bool(frames), "nothing came")
    _require_numbers(frames)
    return " and ".join(sorted({type(frame).__name__ for frame in frames}))


def _require_numbers(frames: list[Any]) -> None:
    """NotShown where all that came was nan: its shape is right, and it says nothing."""
    pressures = np.array([frame.pressures for frame in frames if isinstance(frame, Reading)]).reshape(-1, 4)
    silent = np.flatnonzero(~np.isfinite(pressures).any(axis=0)) if len(pressures) else np.array([], int)
    if len(silent):
        names = ", ".join(CHAMBERS[i] for i in silent)
        raise NotShown(f"the sensors of {names} never gave a number, nan alone", "sensors that are connected")
    seen = [frame.angles if isinstance(frame, Angles) else frame.points for frame in frames if not _is_reading(frame)]
    if seen and not any(np.isfinite(values).any() for values in seen):
        raise NotShown(f"of {len(seen)} frames none had a point that is seen", "a marker within the camera's view")


def _is_reading(frame: Any) -> bool:
    return isinstance(frame, Reading)


def shows_metres(trial: Trial) -> str:
    """A marker at a known distance is seen there."""
    nearest = math.inf
    with trial.opened() as device:
        trial.first(device)
        for _ in range(MARKERS):
            frame = trial.call(device)
            if isinstance(frame, Sample) and np.isfinite(frame.points).all(axis=1).any():
                distance = np.linalg.norm(frame.points[np.isfinite(frame.points).all(axis=1)], axis=1)
                if trial.bench is None:
                    raise NotShown(f"a marker is {distance.min():.3f} m from the origin, as it says", "your ruler")
                nearest = min(nearest, float(np.abs(distance - RADIUS).min()))
    if nearest == math.inf:
        raise NotShown("no marker was seen", "a marker within the camera's view, and a ruler")
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
