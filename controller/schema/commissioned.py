"""Which steps of the commissioning stand: accepted, and no line of the rig file that they stand on has changed since.

An accepted step is noted in the rig file with a mark of each of those lines, so that an edit withdraws it wherever it
is made. A rig of real devices closes no loop until the steps of GATE stand (controller/realtime/command_handler.py).
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any, Literal, get_args

from pydantic import JsonValue

from controller.errors import ParameterError

StepName = Literal["drivers", "jog", "frame", "signs", "pressure", "statics", "decay", "identify", "closed_loop"]
STEPS: tuple[StepName, ...] = get_args(StepName)
"""In the order in which they are done."""
GATE: tuple[StepName, ...] = ("drivers", "jog", "frame", "signs")
"""Without these a loop may push the arm away from where it is told to go."""
RESTS_ON: dict[StepName, tuple[StepName, ...]] = {
    "drivers": (),
    "jog": ("drivers",),
    "frame": ("jog",),
    "signs": ("frame",),
    "pressure": ("jog",),
    "statics": ("signs", "pressure"),
    "decay": ("signs", "pressure"),
    "identify": ("statics", "decay"),
    "closed_loop": ("identify",),
}
"""Steps that must stand before; what withdraws one of them withdraws this one, too."""
_CAMERA = ("motion_capture.driver", "motion_capture.options", "motion_capture.rods", "motion_capture.labels")
_VALVES = ("valves.driver", "valves.options")
STANDS_ON: dict[StepName, tuple[str, ...]] = {
    "drivers": ("motion_capture.driver", "motion_capture.options", *_VALVES),
    "jog": (*_VALVES, "valves.chambers", "valves.command"),
    "frame": (*_CAMERA, "motion_capture.frame"),
    "signs": ("motion_capture.frame", "valves.chambers"),
    "pressure": ("valves.measured", "valves.loop", "controller.dead_time", "controller.pneumatic_lag"),
    "statics": (),
    "decay": (),
    "identify": ("actuator",),
    "closed_loop": ("actuator",),
}
"""Lines of the rig file whose values each step has found, or was done with; what it rests on has others."""
Commissioned = Literal["missing", "waived", "accepted"]
"""Of a rig's real devices; waived: by the rig file's `arm_uncommissioned`, with a step of GATE missing."""
MARK_DIGITS = 12


def value_at(values: Mapping[str, Any], field: str) -> JsonValue:
    """What a rig file's `values` have at `field`, as "valves.chambers"; ParameterError where there is no such field."""
    at: Any = values
    for name in field.split("."):
        if not isinstance(at, Mapping) or name not in at:
            raise ParameterError(f"a rig file has no {field}")
        at = at[name]
    found: JsonValue = at
    return found


def marks(step: StepName, values: Mapping[str, Any]) -> dict[str, str]:
    """A mark of each line on which `step` stands, by its field."""
    return {field: _mark(value_at(values, field)) for field in STANDS_ON[step]}


def changed_lines(step: StepName, noted: Mapping[str, str], values: Mapping[str, Any]) -> list[str]:
    """Lines under `step` that differ from what was `noted` of them."""
    return [field for field, mark in marks(step, values).items() if noted.get(field) != mark]


def withdrawn(
    accepted: Mapping[str, str], noted: Mapping[str, Mapping[str, str]], values: Mapping[str, Any]
) -> dict[StepName, str]:
    """Steps that were `accepted` and stand no longer, and why."""
    found: dict[StepName, str] = {}
    for step in STEPS:
        if step not in accepted:
            continue
        fallen = [one for one in RESTS_ON[step] if one in found or one not in accepted]
        if step not in noted:
            found[step] = "it was accepted by a version that did not note what it stands on"
        elif lines := changed_lines(step, noted[step], values):
            found[step] = f"{' and '.join(lines)} changed since it was accepted"
        elif fallen:
            found[step] = f"it rests on {fallen[0]}"
    return found


def _mark(value: JsonValue) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:MARK_DIGITS]
