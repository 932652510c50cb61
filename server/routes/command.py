"""Requests to the rig: arm, hold, follow, rest, clear, E-STOP."""

import asyncio
from concurrent.futures import Future
from typing import Any

from fastapi import APIRouter
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse

from controller.schema.messages import CommandReply
from controller.schema.modes import Request
from server.answers import Problem
from server.auth import Identity
from server.deps import Me, Parts
from server.messages import CommandBody
from server.problems import missing
from server.rates import TooOften
from server.services import Services
from server.stop_lane import PRESSED

REFUSED: dict[int | str, dict[str, Any]] = {409: {"model": CommandReply | Problem, "description": "The rig refuses"}}

router = APIRouter(tags=["rig"])


@router.post("/api/command", responses=REFUSED, response_model=CommandReply)
async def command(body: CommandBody, connection: HTTPConnection, parts: Parts, who: Me) -> CommandReply | JSONResponse:
    """Ask the rig for another mode; 409 with its reply when it refuses. Anyone may E-STOP, the rest needs the lease."""
    if body.request != "e_stop":
        _in_turn(connection)
        parts.lease.require(who)
    if body.request == "follow" and body.target is None:
        raise missing("body", "target")
    reply = await _ask(body, parts, who, connection.scope["state"].get(PRESSED))
    return reply if reply.accepted else JSONResponse(reply.model_dump(), 409)


def _in_turn(connection: HTTPConnection) -> None:
    """Raise TooOften where the gate let a command pass only because it might have been an E-STOP."""
    late: TooOften | None = connection.state.late
    if late is not None:
        raise late


async def _ask(
    body: CommandBody, parts: Services, who: Identity, pressed: "Future[CommandReply] | None"
) -> CommandReply:
    """`pressed`: the answer to an E-STOP that was acted on as it came in."""
    parts.lease.touch(who)
    reply = await asyncio.wrap_future(pressed or _asked(body, parts, who))
    asked = body.request.replace("_", "-")
    if reply.accepted:
        parts.events.done(who.name, asked)
    else:
        parts.events.refused(who.name, asked, reply.detail)
    return reply


def _asked(body: CommandBody, parts: Services, who: Identity) -> "Future[CommandReply]":
    if body.request == "e_stop":
        return parts.operator.stop()
    permit = parts.permits.operator(who)
    parts.operator.present(permit)
    target = body.target if body.request == "follow" else None
    return parts.operator.request(Request[body.request.upper()], permit, target)
