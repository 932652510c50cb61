"""What this room asks the planner for. The planner alone imports what plans: here that comes when it is called."""

from controller.arrays import Array
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Lap, Leg, Place
from server.runs.messages import Preview, PreviewBody, RunBody


def lap(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    """What `body` asks for. Raises UnknownReference, and ParameterError for what cannot be followed."""
    from server.drawing.planned import wanted
    from server.runs.laps import allowed_by, lap_of

    allowed = allowed_by(rig, settings, drawn=body.drawing is not None)
    return lap_of(wanted(body, rig, settings), rig, body.laps, allowed)


def leg(rig: RigParameters, lap: Lap, laps: int | None, u: Array, left: Place | None = None) -> Leg:
    """From the torques u (2,) [N m] at which the rig is, to the path, or to where it was left, and to its end.

    Raises ParameterError beyond the limits.
    """
    from controller.reference.library import static_map
    from server.runs.laps import first_leg, next_leg

    smap = static_map(rig.actuator, rig.controller)
    return first_leg(smap, lap, laps, u) if left is None else next_leg(smap, lap, laps, u, left)


def preview(body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> Preview:
    """The run that `body` would be from the torques u (2,) [N m] on, at which the rig stands.

    Raises ParameterError and UnknownReference for what cannot be run at all.
    """
    from server.runs.preview import predicted

    return predicted(body, rig, settings, u)
