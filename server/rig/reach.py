"""How far the rig reaches, as the planner finds it: it alone imports what that needs."""

from functools import cache

from controller.schema.parameters import RigParameters
from server.rig.messages import Workspace


@cache
def workspace(parameters: RigParameters) -> Workspace:
    """The reach map as the page draws it; a tenth of a millimetre is enough for a picture."""
    from controller.reference.feasible.reach import reach_map

    points = reach_map(parameters).p
    rows, columns = points.shape[:2]
    flat = [(round(x, 4), round(y, 4)) for x, y in points.reshape(-1, 2).tolist()]
    return Workspace(rows=rows, columns=columns, points=flat, length=parameters.actuator.length)
