"""A reference from sampled points that anyone may have drawn: sampled for the loop, within reach, led to from rest."""

from dataclasses import dataclass

import numpy as np

from controller.actuator import Actuator
from controller.build_rig import REFERENCE_ROWS
from controller.errors import DataError, ParameterError
from controller.kernels.rod import Array
from controller.parameters import ControllerParameters
from controller.reference.approach import approach
from controller.reference.library import APPROACH, static_map
from controller.reference.path_file import Samples
from controller.reference.period import frequency_of
from controller.reference.reference import Reference
from controller.reference.within_reach import Carried, at_rest, projected, require_near, require_reach

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
    """Whether K_FF is on; where None it is on if the path is periodic (the paper: on in Task 2, off else)."""

    def __post_init__(self) -> None:
        low, high = FREQUENCIES
        if self.frequency is not None and not low <= self.frequency <= high:
            raise ParameterError(f"frequency = {self.frequency:g} Hz is outside [{low:g}, {high:g}]")


def drawn(samples: Samples, actuator: Actuator, wish: Wish) -> tuple[Reference, Carried]:
    """The reference through `samples` with the library's approach from rest in front, and what was projected.

    Points between the samples lie on straight lines. A path that begins at rest has no approach. Raises DataError for a
    path that is too long, and ParameterError for one that leaves the reach unless it may be projected.
    """
    controller = ControllerParameters()
    require_near(samples, actuator)
    p = resampled(samples, controller.dt)
    smap = static_map(actuator, controller)
    path = projected(smap, p)
    if not wish.project:
        require_reach(samples, path, p, actuator)
    lead = np.empty((0, 2)) if at_rest(smap, p[0]) else approach(smap, path.u, round(APPROACH / controller.dt))
    frequency = wish.frequency or frequency_of(path.p, controller.dt)
    feedforward = wish.velocity_feedforward
    return Reference(
        name=samples.path.stem,
        p=np.vstack([lead, path.p]),
        start=len(lead),
        frequency=frequency,
        velocity_feedforward=frequency is not None if feedforward is None else feedforward,
    ), path


def resampled(samples: Samples, dt: float) -> Array:
    """Points (n, 2) [m] every dt [s] from the first sample on. Raises DataError if there is no room for so many."""
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
