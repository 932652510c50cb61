"""How the loop does, and limits of the health figures: those of the operator are the ones that the log speaks of."""

import asyncio

from fastapi import APIRouter

from server.health.alarms import GivenAlarms
from server.health.loop_health import GivenLoop, LoopHealth
from server.health.messages import AlarmLimits
from server.http.who import Me

router = APIRouter(tags=["rig"])


@router.get("/api/alarms")
async def read_alarms(alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """My limits, the defaults where I set none."""
    return await asyncio.to_thread(alarms.read, who)


@router.put("/api/alarms")
async def keep_alarms(body: AlarmLimits, alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """Set my limits."""
    await asyncio.to_thread(alarms.write, who, body)
    return body


@router.delete("/api/alarms")
async def reset_alarms(alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """Back to the defaults."""
    await asyncio.to_thread(alarms.forget, who)
    return AlarmLimits()


@router.get("/api/health/loop")
async def read_loop_health(loop: GivenLoop) -> LoopHealth:
    """How punctual the loop was in the last 10 s, how fast the pressure loops were in the last 30 s."""
    return await asyncio.to_thread(loop.health)
