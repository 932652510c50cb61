"""What this room asks the planner for. The planner alone imports what plans: here that comes when it is called."""

from collections import OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from controller.arrays import Array
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Lap, Leg, Order, Place
from server.runs.learning.seen import Repeat
from server.runs.messages import Preview, PreviewBody, PreviewPart, RunBody

if TYPE_CHECKING:
    from server.runs.preview import PreviewInParts

FIRST, MORE = 0.1, 0.3
"""Times for which a run is foreseen before its first part is told, and each further one [s]."""
NOTHING = Path("/nonexistent")
"""Folder of what was learned of paths, where nothing was."""
KEPT = 6
"""Runs that are being foreseen; who began another one and went away is forgotten."""
_previews: "OrderedDict[str, PreviewInParts]" = OrderedDict()


def lap(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    """What `body` asks for. Raises UnknownReference, and ParameterError for what cannot be followed."""
    from server.drawing.planned import wanted
    from server.runs.laps import allowed_by, lap_of

    allowed = allowed_by(rig, settings, drawn=body.drawing is not None)
    return lap_of(wanted(body, rig, settings), rig, body.laps, allowed)


def leg(order: Order, lessons: Path, u: Array, left: Place | None = None) -> Leg:
    """From the torques u (2,) [N m] at which the rig is, to the path, or to where it was left, and to its end.

    `lessons` is the folder of what was learned of paths. Raises ParameterError beyond the limits, and where nothing can
    be learned.
    """
    from controller.assembly.statics import static_map
    from server.runs.ahead import with_learned
    from server.runs.laps import first_leg, next_leg
    from server.runs.learning.lessons import Lessons

    smap, lap = static_map(order.rig.actuator, order.rig.controller), order.lap
    found = first_leg(smap, lap, order.laps, u) if left is None else next_leg(smap, lap, order.laps, u, left)
    return with_learned(found, order, Lessons(lessons))


def teach(order: Order, lessons: Path, repeat: Repeat) -> None:
    """Learn from a repeat. Raises OSError."""
    from server.runs.learning.lessons import Lessons
    from server.runs.learning.lessons import teach as learn

    learn(Lessons(lessons), order, repeat)


def forget(lessons: Path, key: str) -> bool:
    """Whether something was learned of a path, which is forgotten now. Raises OSError."""
    from server.runs.learning.lessons import Lessons

    return Lessons(lessons).forget(key)


class Asked(NamedTuple):
    """What is to be foreseen: a run from the torques u (2,) [N m] on, at which the rig stands."""

    body: PreviewBody
    rig: RigParameters
    settings: Settings
    u: Array
    lessons: Path


def preview(asked: Asked) -> Preview:
    """Raises ParameterError and UnknownReference for what cannot be run at all."""
    from server.runs.preview import predicted

    return predicted(*asked)


def begin_preview(key: str, asked: Asked) -> PreviewPart:
    """Begin what `preview` does in one go; the first part of it. `key` names it from now on."""
    from server.runs.preview import PreviewInParts

    _previews[key] = PreviewInParts(*asked)
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
