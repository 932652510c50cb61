"""Who the rig is, how it does, and how far it reaches."""

import asyncio

from fastapi import APIRouter

from controller.schema.messages import RigInfo
from server.deps import Parts
from server.loop_health import LoopHealth
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


@router.get("/api/health/loop")
async def read_loop_health(parts: Parts) -> LoopHealth:
    """How punctual the loop was in the last 10 s, how fast the pressure loops were in the last 30 s."""
    return await asyncio.to_thread(parts.loop.health)
