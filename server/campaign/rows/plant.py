"""Pneumatics that break, as the twin's own faults do it: no command brings such chambers to rest."""

from typing import Any

from controller.schema.modes import Cause, Mode
from server.campaign.rows.sensing import latched
from server.campaign.scene import Scene
from server.campaign.waiting import Seen

FIRST = 1
"""The chamber u1+, as a bit."""


def sensor_stuck(scene: Scene) -> Seen:
    """The valve's own loop believes it too."""
    return _vented(scene, sensors_stuck=FIRST)


def valve_stuck(scene: Scene) -> Seen:
    """The chamber fills or empties on."""
    return _vented(scene, valves_stuck=FIRST)


def supply_lost(scene: Scene) -> Seen:
    """All chambers empty."""
    return _vented(scene, supply_lost=True)


def _vented(scene: Scene, **faults: Any) -> Seen:
    return latched(scene, Mode.E_STOP, Cause.PRESSURE_MISMATCH, 2.0, **faults)
