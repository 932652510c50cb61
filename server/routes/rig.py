"""Who the rig is, how it does, and how far it reaches."""

from fastapi import APIRouter

from controller.messages import RigInfo
from server.deps import Parts
from server.messages import Health

router = APIRouter(tags=["rig"])


@router.get("/api/rig")
async def rig_info(parts: Parts) -> RigInfo:
    """The rig's identity and parameters; 503 before the first contact."""
    return parts.require_info()


@router.get("/api/health")
async def read_health(parts: Parts) -> Health:
    """Whether the rig is heard, and how fast it answers."""
    return parts.health()
