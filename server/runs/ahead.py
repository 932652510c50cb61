"""Torques that are planned along a leg, where the controller in the slot follows such, as far as it is learned."""

from dataclasses import replace

import numpy as np

from controller.arrays import Array
from controller.assembly.controllers.registry import controllers
from controller.errors import ParameterError
from controller.reference.learning import led_in
from controller.reference.torques import planned_torques
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Leg, Order
from server.runs.learning.lessons import Course, Lessons, key_of, untaught_course
from server.runs.messages import Learned, Learning

AFTER_S = 2.0
"""Of a third lap the second one's plan knows so much: it does not come to rest at its end [s]."""


def with_learned(leg: Leg, order: Order, lessons: Lessons) -> Leg:
    """`leg` with its plan, as the order's `learning` has it. Raises ParameterError where nothing can be learned."""
    rig, settings, learning = order.rig, order.settings, order.learning
    chosen = controllers()[settings.controller]
    if not chosen.plans:
        require_none(learning, chosen.name)
        return leg
    if learning == "off":
        return with_plan(leg, rig, settings)
    key, repeats = key_of(order), learning in ("on", "anew")
    course = None if learning == "anew" else lessons.read(key)
    if course is None and not repeats:
        return with_plan(leg, rig, settings)
    course = course or untaught_course(len(order.lap.p), rig)
    found = with_plan(leg, rig, settings, corrections(leg, course, repeats, rig.controller.dt))
    return replace(found, learned=Learned(key=key, learning=repeats, errors=course.errors))


def require_none(learning: Learning, name: str) -> None:
    """Raise ParameterError where something is to be learned by the controller of this name, which follows no plan."""
    if learning in ("on", "anew"):
        able = ", ".join(one.name for one in controllers() if one.plans)
        raise ParameterError(f"learning = {learning}: controller {name} follows no planned torques; {able} does")


def corrections(leg: Leg, course: Course, repeats: bool, dt: float) -> Array:
    """(m,2) [m] of the rows that are planned for; `repeats`: those that the next repeat tries, else the best one's.

    What leads onto the path, as after a pause, too, is led over to them at its end.
    """
    first, laps = ((one.next if repeats else one.best) for one in (course.first, course.laps))
    row = leg.done + np.arange(max(ticks_ahead(leg, dt) - leg.again, 1))
    place = row % len(first)
    c = np.where((row < len(first))[:, None], first[place], laps[place])
    return np.vstack([led_in(c, leg.again, dt), c])


def with_plan(leg: Leg, rig: RigParameters, settings: Settings, correction: Array | None = None) -> Leg:
    """`leg` with torques for its rows, and for all of its laps but the first, which begins from rest.

    `correction` (m,2) [m] is added to the rows that are planned for.
    """
    n, lap = len(leg.p), len(leg.p) - leg.again
    row = leg.row(np.arange(ticks_ahead(leg, rig.controller.dt)))
    asked = leg.p[row] if correction is None else leg.p[row] + correction[: len(row)]
    found = planned_torques(rig.actuator, rig.controller, asked, leg.u[row])
    again = None
    if leg.ticks > n:
        again = found[n : n + lap]
        again = np.vstack([again, leg.u[leg.again + len(again) :]])  # the last rows, where no lap comes to them
    return replace(leg, planned=found[:n], planned_again=again)


def ticks_ahead(leg: Leg, dt: float) -> int:
    """For how many ticks of a leg torques are planned: two laps, and some of a third, where there are so many."""
    n, lap = len(leg.p), len(leg.p) - leg.again
    return min(leg.ticks, n + lap + min(lap, round(AFTER_S / dt))) if leg.ticks > n else n
