"""A path that is learned by repeating it: what the plan is asked for beyond the path, from the errors of the repeats.

The plan (`torques.py`) is the inverse of the nominal model; an arm that is another does not come where it is led. What
is left of the error after a repeat is added, smoothed, to the path that is planned for the next one:
    c_{k+1} = c_k + gamma Q e_k,    |c| <= a quarter of the arm's length.
The path that the error is taken from, and that feedback knows, stays what was drawn. With G the arm's response times
that of the inverse, a repeat leaves 1 - gamma Q G of the error: Q lets through what is slow enough for G to be near 1.
Where a repeat leaves more than the best one did, learning goes on from that one with a lower cutoff of Q, so an arm
for which Q was too quick is learned more slowly, and what is kept is never worse than what was.
Bristow, Tharayil, Alleyne, "A survey of iterative learning control", IEEE Control Systems Magazine 26 (2006), where it
is the serial kind: the reference of a loop is learned, not its torque.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.reference.torques import filtered, late_of, slow
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters

GAMMA = 0.7
"""Share of the error that is added."""
CUTOFF, CUTOFF_LEAST = 0.9, 0.15
"""Of Q at the first repeat, and where nothing more is to be learned [times the frequency of the first mode]."""
FALLS = 0.75
"""By what the cutoff is multiplied after a repeat that left more than the best."""
CORRECTION_MAX = 0.25
"""[lengths of the arm]"""
SEEN_MIN = 0.9
"""Nothing is learned of a repeat in which the tip was seen in a smaller share of the ticks."""
LEAD_S = 0.2
"""Time in which the correction comes in before the path begins [s]."""


@dataclass(frozen=True, eq=False)
class Lesson:
    """What is learned of a path of n rows."""

    next: Array
    """Correction (n,2) [m] that the next repeat tries."""
    best: Array
    """That of the best repeat so far."""
    left: Array
    """Error (n,2) [m] that this one left; 0 before the first."""
    bound: float
    """Of the correction [m]."""
    cutoff: float
    """Of Q [Hz]."""
    cutoff_least: float
    """Below it nothing more is to be learned [Hz]."""
    rmse: float = math.inf
    """Of `left` [m]."""
    repeats: int = 0

    @property
    def over(self) -> bool:
        """Whether nothing more is to be learned: the next repeat is the best one once more."""
        return self.cutoff < self.cutoff_least


def untaught(n: int, actuator: Actuator, controller: ControllerParameters) -> Lesson:
    """Before the first repeat of a path of n rows by this arm."""
    none, mode = np.zeros((n, 2)), late_of(actuator, controller).omega / (2.0 * math.pi)
    return Lesson(none, none, none, CORRECTION_MAX * actuator.length, CUTOFF * mode, CUTOFF_LEAST * mode)


def taught(lesson: Lesson, error: Array | None, dt: float, laps: bool = False) -> Lesson:
    """`lesson` after a repeat of its `next` that left the error (n,2) [m], rows dt [s] apart; None: it was broken off.

    `laps`: its last row is followed by its first. Raises DataError for an error of another length.
    """
    if error is not None and error.shape != lesson.next.shape:
        raise DataError(f"{len(error)} rows of error for a path of {len(lesson.next)}")
    after = replace(lesson, repeats=lesson.repeats + 1)
    if error is not None and (left := _rms(error)) < lesson.rmse:
        after = replace(after, best=lesson.next, left=error, rmse=left)
    else:
        after = replace(after, cutoff=FALLS * lesson.cutoff)
    if after.over or not math.isfinite(after.rmse):
        return replace(after, next=after.best)
    step = smoothed(after.left, after.cutoff, dt, laps)
    return replace(after, next=bounded(after.best + GAMMA * step, lesson.bound))


def smoothed(x: Array, cutoff: float, dt: float, laps: bool = False) -> Array:
    """Q x of the module, x (n,2); `laps`: its last row is followed by its first."""
    if not laps:
        return filtered(x, dt, lambda f: slow(f, cutoff))
    return filtered(np.vstack([x, x, x]), dt, lambda f: slow(f, cutoff))[len(x) : 2 * len(x)]


def bounded(c: Array, bound: float) -> Array:
    """c (n,2) [m], nowhere longer than `bound` [m]."""
    return np.asarray(c * np.minimum(1.0, bound / np.maximum(np.linalg.norm(c, axis=1), 1e-9))[:, None])


def led_in(c: Array, rows: int, dt: float) -> Array:
    """(rows,2) [m] before a path with the correction c (n,2): none, then smoothly its first."""
    t = np.clip(1.0 - (np.arange(rows, 0, -1) - 1) * dt / LEAD_S, 0.0, 1.0)
    return np.asarray((t**2 * (3.0 - 2.0 * t))[:, None] * c[0])


def path_errors(p: Array, p_meas: Array, age: Array, dt: float) -> Array | None:
    """p - tip (n,2) [m] at every tick, of a tip p_meas (n,2) that was seen `age` (n,) [s] before.

    Each tick has the tip as it was then, which is known later; between two images it went straight on. None where less
    than SEEN_MIN of the ticks saw it.
    """
    finite = np.isfinite(p_meas).all(axis=1)
    if not len(p) or finite.mean() < SEEN_MIN:
        return None
    at, row = np.unique(np.arange(len(p))[finite] - np.round(age[finite] / dt).astype(int), return_index=True)
    seen = p_meas[finite][row]
    return p - np.column_stack([np.interp(np.arange(len(p)), at, seen[:, j]) for j in range(2)])


def _rms(e: Array) -> float:
    return math.sqrt(float(np.mean(np.sum(e**2, axis=1))))
