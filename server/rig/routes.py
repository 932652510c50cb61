"""Who the rig is, and how far it reaches."""

from fastapi import APIRouter

from controller.schema.messages import RigInfo
from server.rig.client import GivenRig
from server.rig.messages import Workspace
from server.rig.planner import GivenPlanner
from server.rig.reach import workspace

router = APIRouter(tags=["rig"])


@router.get("/api/rig")
async def rig_info(rig: GivenRig) -> RigInfo:
    """The rig's identity and parameters; 503 before the first contact."""
    return rig.require_info()


@router.get("/api/workspace")
async def read_workspace(rig: GivenRig, planner: GivenPlanner) -> Workspace:
    """Reach of the connected rig's actuator; 503 before the first contact."""
    return await planner.do(workspace, rig.require_info().parameters)
