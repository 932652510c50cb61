"""A reference from sampled points that anyone may have drawn: sampled for the loop, within reach, led to from rest."""

import math
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import DataError, ParameterError
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import approach
from controller.reference.feasible.course import course, torn
from controller.reference.feasible.from_rest import leaving_rest
from controller.reference.feasible.within_reach import Carried, is_rest, projected, require_near, require_reach
from controller.reference.library import APPROACH
from controller.reference.path_file import Samples
from controller.reference.reference import Reference
from controller.schema.actuator import Actuator
from controller.schema.parameters import REFERENCE_ROWS, ControllerParameters

ON_GRID = 1e-6
"""A sample that is this near to a tick is on it, so that a path sampled like the loop stays as it is [ticks]."""

FREQUENCIES = (0.01, 100.0)
"""What may be said to be the frequency of a path [Hz]."""


@dataclass(frozen=True)
class Wish:
    """How a drawn path is to be taken."""

    project: bool = False
    """Follow the nearest points within reach where the path is out of reach, instead of refusing it."""
    frequency: float | None = None
    """[Hz]; found if the path repeats at least once where None."""
    velocity_feedforward: bool | None = None
    """Whether K_FF is on; where None it is on if the path is periodic and does not jump (the paper: on in Task 2)."""
    start: float | None = None
    """When the shape begins after an approach of the file's own [s after its first row]; found where None."""

    def __post_init__(self) -> None:
        if self.start is not None and not 0.0 <= self.start < math.inf:
            raise ParameterError(f"start = {self.start:g} s is outside [0, inf)")
        low, high = FREQUENCIES
        if self.frequency is not None and not low <= self.frequency <= high:
            raise ParameterError(f"frequency = {self.frequency:g} Hz is outside [{low:g}, {high:g}]")


def drawn(samples: Samples, actuator: Actuator, wish: Wish) -> tuple[Reference, Carried]:
    """The reference through `samples` with the library's approach from rest in front, and what was projected.

    Points between the samples lie on straight lines. A path that begins at rest approaches by itself, and its shape
    begins later. Raises DataError for a path that is too long, and ParameterError for one that leaves the reach unless
    it may be projected, or that has no row at the wished start.
    """
    controller = ControllerParameters()
    require_near(samples, actuator)
    p = resampled(samples, controller.dt)
    first = start_row(samples, wish, len(p), controller.dt)
    smap = static_map(actuator, controller)
    lead, path = led(smap, p, controller.dt)
    if not wish.project:
        require_reach(samples, path, p, actuator)
    found = course(path.p, controller.dt, not len(lead), first, wish.frequency)
    on = found.frequency is not None and not found.steps and not torn(path.p[found.start :], controller.dt)
    return Reference(
        name=samples.path.stem,
        p=np.vstack([lead, path.p]),
        start=len(lead) + found.start,
        steps=tuple(len(lead) + row for row in found.steps),
        frequency=found.frequency,
        velocity_feedforward=on if wish.velocity_feedforward is None else wish.velocity_feedforward,
        axis_frequencies=found.axis_frequencies,
        led=len(lead),
        known=not (path.distance > 0.0).any() and not torn(path.p, controller.dt),
    ), path


def led(smap: StaticMap, p: Array, dt: float) -> tuple[Array, Carried]:
    """The approach (m, 2) [m] from rest, of no rows for a path that begins there, and p (n, 2) [m] within reach."""
    if is_rest(smap, p[0]):
        return np.empty((0, 2)), projected(smap, leaving_rest(smap, p))
    path = projected(smap, p)
    return approach(smap, path.u[0], round(APPROACH / dt)), path


def start_row(samples: Samples, wish: Wish, rows: int, dt: float) -> int | None:
    """Row at the wished start, of `rows` rows every dt [s]; None where it is to be found."""
    if wish.start is None:
        return None
    row = round(wish.start / dt) if wish.start < rows * dt else rows
    if row > rows - 2:
        raise ParameterError(f"start = {wish.start:g} s, but {samples.path} ends after {(rows - 1) * dt:g} s")
    return row


def resampled(samples: Samples, dt: float) -> Array:
    """Points (n, 2) [m] every dt [s] from the first sample on. Raises DataError if there is no room for them."""
    at = (samples.t - samples.t[0]) / dt
    whole = np.round(at)
    at = np.where(np.abs(at - whole) < ON_GRID, whole, at)
    room = REFERENCE_ROWS - round(APPROACH / dt)
    if at[-1] > room - 1:
        raise DataError(
            f"{samples.path}: t runs over {samples.t[-1] - samples.t[0]:.6g} s, the rig's memory holds "
            f"{(room - 1) * dt:g} s (a time that is not in s needs its unit in the header, as in t_ms)"
        )
    ticks = np.arange(int(at[-1]) + 1)
    if ticks.size < 2:
        raise DataError(f"{samples.path}: t runs over {1e3 * at[-1] * dt:.3g} ms, less than a tick of {1e3 * dt:g} ms")
    return np.column_stack([np.interp(ticks, at, samples.p[:, j]) for j in range(2)])
