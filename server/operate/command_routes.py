"""Requests to the rig: arm, hold, follow, rest, clear, E-STOP.

They are answered in the network's loop (`server/app/application_loop.py`), whatever the application is at: what is used
here is thread safe.
"""

import asyncio
from concurrent.futures import Future
from typing import Any

from fastapi import APIRouter
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse

from controller.schema.messages import CommandReply
from controller.schema.modes import Request
from server.http.answers import Problem
from server.http.problems import missing
from server.http.rates import TooOften
from server.http.who import Identity, Me
from server.operate.messages import CommandBody
from server.operate.target_control import GivenTargetContext, TargetContext, TargetControl

REFUSED: dict[int | str, dict[str, Any]] = {409: {"model": CommandReply | Problem, "description": "The rig refuses"}}

router = APIRouter(tags=["rig"])


@router.post("/api/command", responses=REFUSED, response_model=CommandReply)
async def command(
    body: CommandBody, connection: HTTPConnection, context: GivenTargetContext, who: Me
) -> CommandReply | JSONResponse:
    """Ask the rig for another mode; 409 with its reply when it refuses. Anyone may E-STOP, the rest needs the lease."""
    if body.request != "e_stop":
        _not_too_often(connection)
        context.lease.require(who)
    if body.request == "follow" and body.target is None:
        raise missing("body", "target")
    context.lease.touch(who)
    reply = await asyncio.wrap_future(_asked(body, context, who))
    context.events.answered(who.described, body.request.replace("_", "-"), reply)
    return reply if reply.accepted else JSONResponse(reply.model_dump(), 409)


def _not_too_often(connection: HTTPConnection) -> None:
    """Raise TooOften where the gate let a command pass only because it might have been an E-STOP."""
    late: TooOften | None = connection.state.late
    if late is not None:
        raise late


def _asked(body: CommandBody, context: TargetContext, who: Identity) -> "Future[CommandReply]":
    if body.request == "e_stop":
        return context.operator.stop(who.described)
    target = TargetControl(who, context)
    if body.target is not None and body.request == "follow":
        return target.press(body.target)
    return target.ask(Request[body.request.upper()])
