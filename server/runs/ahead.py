"""Torques that are planned along a leg, where the controller in the slot follows such."""

from dataclasses import replace

import numpy as np

from controller.assembly.controllers.registry import controllers
from controller.reference.torques import planned_torques
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Leg

AFTER_S = 2.0
"""Of a third lap the second one's plan knows so much: it does not come to rest at its end [s]."""


def with_plan(leg: Leg, rig: RigParameters, settings: Settings) -> Leg:
    """`leg` with torques for its rows, and for all of its laps but the first, which begins from rest."""
    if not controllers()[settings.controller].plans:
        return leg
    n, lap = len(leg.p), len(leg.p) - leg.again
    repeats = leg.ticks > n
    ahead = n + lap + min(lap, round(AFTER_S / rig.controller.dt)) if repeats else n
    row = leg.row(np.arange(min(ahead, leg.ticks)))
    found = planned_torques(rig.actuator, rig.controller, leg.p[row], leg.u[row])
    again = None
    if repeats:
        again = found[n : n + lap]
        again = np.vstack([again, leg.u[leg.again + len(again) :]])  # the last rows, where no lap comes to them
    return replace(leg, planned=found[:n], planned_again=again)
