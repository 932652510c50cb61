"""What this room asks the planner for. The planner alone imports what plans: here that comes when it is called."""

from collections import OrderedDict
from typing import TYPE_CHECKING

from controller.arrays import Array
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Lap, Leg, Place
from server.runs.messages import Preview, PreviewBody, PreviewPart, RunBody

if TYPE_CHECKING:
    from server.runs.preview import PreviewInParts

FIRST, MORE = 0.1, 0.3
"""Times for which a run is foreseen before its first part is told, and each further one [s]."""
KEPT = 6
"""Runs that are being foreseen; who began another one and went away is forgotten."""
_previews: "OrderedDict[str, PreviewInParts]" = OrderedDict()


def lap(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    """What `body` asks for. Raises UnknownReference, and ParameterError for what cannot be followed."""
    from server.drawing.planned import wanted
    from server.runs.laps import allowed_by, lap_of

    allowed = allowed_by(rig, settings, drawn=body.drawing is not None)
    return lap_of(wanted(body, rig, settings), rig, body.laps, allowed)


def leg(rig: RigParameters, settings: Settings, lap: Lap, laps: int | None, u: Array, left: Place | None = None) -> Leg:
    """From the torques u (2,) [N m] at which the rig is, to the path, or to where it was left, and to its end.

    Raises ParameterError beyond the limits.
    """
    from controller.assembly.statics import static_map
    from server.runs.ahead import with_plan
    from server.runs.laps import first_leg, next_leg

    smap = static_map(rig.actuator, rig.controller)
    found = first_leg(smap, lap, laps, u) if left is None else next_leg(smap, lap, laps, u, left)
    return with_plan(found, rig, settings)


def preview(body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> Preview:
    """The run that `body` would be from the torques u (2,) [N m] on, at which the rig stands.

    Raises ParameterError and UnknownReference for what cannot be run at all.
    """
    from server.runs.preview import predicted

    return predicted(body, rig, settings, u)


def begin_preview(key: str, body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> PreviewPart:
    """Begin what `preview` does in one go; the first part of it. `key` names it from now on."""
    from server.runs.preview import PreviewInParts

    _previews[key] = PreviewInParts(body, rig, settings, u)
    while len(_previews) > KEPT:
        _previews.popitem(last=False)
    return _more(key, FIRST)


def go_on_with_preview(key: str) -> PreviewPart | None:
    """The next part of it; None where it is not known any more."""
    return _more(key, MORE) if key in _previews else None


def drop_preview(key: str) -> None:
    """No one wants more of it."""
    _previews.pop(key, None)


def _more(key: str, seconds: float) -> PreviewPart:
    found = _previews[key]
    _previews.move_to_end(key)
    found.go_on(seconds)
    return found.part()
