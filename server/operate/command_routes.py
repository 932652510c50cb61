"""Requests to the rig: arm, hold, follow, rest, clear, E-STOP."""

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from fastapi import APIRouter
from pydantic import ValidationError
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import Scope

from controller.schema.messages import CommandReply
from controller.schema.modes import Request
from server.access.gate import COMMAND
from server.http.answers import Problem
from server.http.problems import missing
from server.http.rates import TooOften
from server.http.who import Identity, Me
from server.operate.messages import CommandBody
from server.operate.target_control import GivenTargetContext, TargetContext, TargetControl

PRESSED = "pressed"
"""In the state of a request that was an E-STOP: the future of its answer."""
BODY_MAX_BYTES = 256
"""Bytes of an E-STOP's body."""
REFUSED: dict[int | str, dict[str, Any]] = {409: {"model": CommandReply | Problem, "description": "The rig refuses"}}

router = APIRouter(tags=["rig"])


@router.post("/api/command", responses=REFUSED, response_model=CommandReply)
async def command(
    body: CommandBody, connection: HTTPConnection, context: GivenTargetContext, who: Me
) -> CommandReply | JSONResponse:
    """Ask the rig for another mode; 409 with its reply when it refuses. Anyone may E-STOP, the rest needs the lease."""
    if body.request != "e_stop":
        _in_turn(connection)
        context.lease.require(who)
    if body.request == "follow" and body.target is None:
        raise missing("body", "target")
    context.lease.touch(who)
    # The answer to an E-STOP that was acted on as it came in:
    pressed: Future[CommandReply] | None = connection.scope["state"].get(PRESSED)
    reply = await asyncio.wrap_future(pressed or _asked(body, context, who))
    context.events.answered(who.described, body.request.replace("_", "-"), reply)
    return reply if reply.accepted else JSONResponse(reply.model_dump(), 409)


def _in_turn(connection: HTTPConnection) -> None:
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


class StopLane:
    """The E-STOP by HTTP: acted on as its last byte comes in, before the turns of the event loop that its answer takes.

    Told of every request that is whole. `admitted` says who asks, as the gate judges, without its bookkeeping.
    """

    def __init__(
        self, admitted: Callable[[Scope], Identity | None], stop: "Callable[[str], Future[CommandReply]]"
    ) -> None:
        self._admitted, self._stop = admitted, stop

    def __call__(self, scope: Scope, body: bytes) -> None:
        """Stop, if that is what an admitted request asks for; its route answers as ever."""
        if scope.get("path") != COMMAND or scope["method"] != "POST" or not _is_stop(scope, body):
            return
        if who := self._admitted(scope):
            scope["state"][PRESSED] = self._stop(who.described)


def _is_stop(scope: Scope, body: bytes) -> bool:
    kind = Headers(scope=scope).get("content-type", "").partition(";")[0].strip().lower()
    if len(body) > BODY_MAX_BYTES or b"e_stop" not in body or kind != "application/json":
        return False
    try:
        return CommandBody.model_validate_json(body).request == "e_stop"
    except ValidationError:
        return False
