"""How the loop does, limits of the health figures, and what a probe and Prometheus ask for."""

import asyncio

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST

from server.health.alarms import GivenAlarms
from server.health.healthz import GivenProbed, Healthz, healthz
from server.health.loop_health import GivenLoop, LoopHealth
from server.health.messages import AlarmLimits
from server.health.metrics import GivenFigures, exposition
from server.http import answers
from server.http.who import Me

router = APIRouter()


@router.get("/api/alarms", tags=["rig"])
async def read_alarms(alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """My limits, the defaults where I set none."""
    return await asyncio.to_thread(alarms.read, who)


@router.put("/api/alarms", tags=["rig"])
async def keep_alarms(body: AlarmLimits, alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """Set my limits."""
    await asyncio.to_thread(alarms.write, who, body)
    return body


@router.delete("/api/alarms", tags=["rig"])
async def reset_alarms(alarms: GivenAlarms, who: Me) -> AlarmLimits:
    """Back to the defaults."""
    await asyncio.to_thread(alarms.forget, who)
    return AlarmLimits()


@router.get("/api/health/loop", tags=["rig"])
async def read_loop_health(loop: GivenLoop) -> LoopHealth:
    """How punctual the loop was in the last 10 s, how fast the pressure loops were in the last 30 s."""
    return await asyncio.to_thread(loop.health)


@router.get(
    "/healthz", tags=["monitoring"], responses={503: {"model": Healthz, "description": "Something is not well"}}
)
async def read_healthz(probed: GivenProbed, response: Response) -> Healthz:
    """Whether all is well, 503 when something is not; open to anyone on this machine."""
    found = await healthz(probed)
    response.status_code = 200 if found.ok else 503
    return found


@router.get(
    "/metrics",
    tags=["monitoring"],
    response_class=Response,
    responses=answers.body("text/plain", "Prometheus' text format"),
)
async def read_metrics(figures: GivenFigures) -> Response:
    """Figures for Prometheus, with a session or `Authorization: Bearer ACCESS_TOKEN`."""
    return Response(exposition(figures), media_type=CONTENT_TYPE_LATEST)
