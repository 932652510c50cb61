"""A planned reference on the twin, learned by repeating it."""

import math
from dataclasses import dataclass, replace

import numpy as np

from controller.arrays import Array
from controller.assembly.controllers.registry import controllers
from controller.errors import ParameterError
from controller.reference.learning import led_in, path_errors, taught, untaught
from controller.reference.reference import Reference
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.metrics import rmse, tip
from controller.simulation.run import attempt
from controller.system.progress import ProgressCallback, no_progress


@dataclass(frozen=True, eq=False)
class Learned:
    """What came of the repeats."""

    reference: Reference
    """With what is to be planned for, as the best of them had it."""
    rmse: tuple[float, ...]
    """Of the tip after the approach [m], one a repeat; nan for one that was broken off."""


def learn(
    parameters: RigParameters,
    reference: Reference,
    settings: Settings,
    seeds: range,
    told: ProgressCallback = no_progress,
) -> Learned:
    """Repeat the reference with these seeds of the twin's noise, and learn from what is measured of the tip.

    The approach is planned as ever. Raises ParameterError where the controller of `settings` follows no plan.
    """
    require_plans(settings)
    dt, start, found = parameters.controller.dt, reference.start, []
    lesson = untaught(len(reference.p) - start, parameters.actuator, parameters.controller)
    for n, seed in enumerate(seeds):
        rows = attempt(parameters, asking(reference, lesson.next, dt), settings, seed)
        error, whole = None, bool((rows["mode"] == Mode.TRACK).all())
        if whole:
            error = path_errors(reference.p, rows["p_meas"], rows["measurement_age"], dt)
        found.append(rmse((reference.p - tip(rows))[start:]) if whole else math.nan)
        lesson = taught(lesson, None if error is None else error[start:], dt)
        told((n + 1) / len(seeds))
    return Learned(asking(reference, lesson.best, dt), tuple(found))


def asking(reference: Reference, c: Array, dt: float) -> Reference:
    """`reference` planned with the correction c (n,2) [m] of its rows after the approach, which are dt [s] apart."""
    return replace(reference, asked=reference.p + np.vstack([led_in(c, reference.start, dt), c]))


def require_plans(settings: Settings) -> None:
    """Raise ParameterError where the controller of `settings` follows no plan, so that nothing can be learned."""
    chosen = controllers()[settings.controller]
    if not chosen.plans:
        able = ", ".join(one.name for one in controllers() if one.plans)
        raise ParameterError(f"controller = {chosen.name!r} follows no planned torques, so it learns nothing: {able}")
