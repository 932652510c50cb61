"""What this room asks the planner for. The planner alone imports what plans: here that comes when it is called."""

from controller.schema.parameters import RigParameters, Settings
from server.drawing.messages import DrawingBody, DrawingPlan, ReferenceInfo, ReferencePath


def menu(rig: RigParameters) -> list[ReferenceInfo]:
    """The references for this rig's actuator."""
    from server.drawing.references import listed

    return listed(rig)


def reference_path(rig: RigParameters, name: str) -> ReferencePath:
    """The points of one; raises UnknownReference with the known names."""
    from server.drawing.references import path

    return path(rig, name)


def drawing_plan(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> DrawingPlan:
    """What would be followed. Raises ParameterError for what cannot be timed."""
    from server.drawing.plan import drawing_plan

    return drawing_plan(drawing, rig, settings)


def drawing_csv(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> str:
    """The same as t, x, y every tick, as `tendril track` reads it. Raises ParameterError."""
    from server.drawing.plan import csv_of

    return csv_of(drawing, rig, settings)
