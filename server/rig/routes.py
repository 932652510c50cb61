"""Who the rig is, and how far it reaches."""

import asyncio
from functools import cache

from fastapi import APIRouter

from controller.reference.feasible.reach import reach_map
from controller.schema.messages import RigInfo
from controller.schema.parameters import RigParameters
from server.rig.client import GivenRig
from server.rig.messages import Workspace

router = APIRouter(tags=["rig"])


@router.get("/api/rig")
async def rig_info(rig: GivenRig) -> RigInfo:
    """The rig's identity and parameters; 503 before the first contact."""
    return rig.require_info()


@router.get("/api/workspace")
async def read_workspace(rig: GivenRig) -> Workspace:
    """Reach of the connected rig's actuator; 503 before the first contact."""
    return await asyncio.to_thread(workspace, rig.require_info().parameters)


@cache
def workspace(parameters: RigParameters) -> Workspace:
    """The reach map as the page draws it; a tenth of a millimetre is enough for a picture."""
    points = reach_map(parameters).p
    rows, columns = points.shape[:2]
    flat = [(round(x, 4), round(y, 4)) for x, y in points.reshape(-1, 2).tolist()]
    return Workspace(rows=rows, columns=columns, points=flat, length=parameters.actuator.length)
