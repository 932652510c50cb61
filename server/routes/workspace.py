"""How far the tip reaches."""

import asyncio
from functools import cache

from fastapi import APIRouter

from controller.reference.feasible.reach import reach_map
from controller.schema.parameters import RigParameters
from server.deps import Parts
from server.messages import Workspace

router = APIRouter(tags=["rig"])


@router.get("/api/workspace")
async def read_workspace(parts: Parts) -> Workspace:
    """Reach of the connected rig's actuator; 503 before the first contact."""
    return await asyncio.to_thread(workspace, parts.require_info().parameters)


@cache
def workspace(parameters: RigParameters) -> Workspace:
    """The reach map as the page draws it; a tenth of a millimetre is enough for a picture."""
    points = reach_map(parameters).p
    rows, columns = points.shape[:2]
    flat = [(round(x, 4), round(y, 4)) for x, y in points.reshape(-1, 2).tolist()]
    return Workspace(rows=rows, columns=columns, points=flat, length=parameters.actuator.length)
