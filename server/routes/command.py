"""Requests to the rig: arm, hold, follow, rest, clear, E-STOP."""

import asyncio

from fastapi import APIRouter
from starlette.responses import JSONResponse

from controller.messages import CommandReply
from controller.modes import Request
from server.auth import Identity
from server.deps import Me, Parts
from server.messages import CommandBody
from server.problems import missing
from server.services import Services

router = APIRouter(tags=["rig"])


@router.post("/api/command", responses={409: {"model": CommandReply}}, response_model=CommandReply)
async def command(body: CommandBody, parts: Parts, who: Me) -> CommandReply | JSONResponse:
    """Ask the rig for another mode; 409 with its reply when it refuses. Anyone may E-STOP, the rest needs the lease."""
    if body.request != "e_stop":
        parts.lease.require(who)
    if body.request == "follow" and body.target is None:
        raise missing("body", "target")
    reply = await _ask(body, parts, who)
    return reply if reply.accepted else JSONResponse(reply.model_dump(), 409)


async def _ask(body: CommandBody, parts: Services, who: Identity) -> CommandReply:
    if parts.lease.holds(who):
        parts.lease.touch(who)
        parts.operator.present()
    target = body.target if body.request == "follow" else None
    reply = await asyncio.wrap_future(parts.operator.request(Request[body.request.upper()], target))
    asked = body.request.replace("_", "-")
    if reply.accepted:
        parts.events.add(f"{who.name}: {asked}")
    else:
        parts.events.refused(who.name, asked, reply.detail)
    return reply
