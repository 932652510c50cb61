"""Limits of the health figures, kept for the browser that asks; the operator's are those that the log speaks of."""

import asyncio

from fastapi import APIRouter

from server.alarms.messages import AlarmLimits
from server.deps import Me, Parts

router = APIRouter(tags=["rig"])


@router.get("/api/alarms")
async def read_alarms(parts: Parts, who: Me) -> AlarmLimits:
    """My limits, the defaults where I set none."""
    return await asyncio.to_thread(parts.alarms.read, who)


@router.put("/api/alarms")
async def keep_alarms(body: AlarmLimits, parts: Parts, who: Me) -> AlarmLimits:
    """Set my limits."""
    await asyncio.to_thread(parts.alarms.write, who, body)
    return body


@router.delete("/api/alarms")
async def reset_alarms(parts: Parts, who: Me) -> AlarmLimits:
    """Back to the defaults."""
    await asyncio.to_thread(parts.alarms.forget, who)
    return AlarmLimits()
