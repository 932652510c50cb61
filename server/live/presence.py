"""The presence socket: signs of an open page, from a worker of it that a busy main thread does not hold up.

The live socket belongs to the page's main thread, which may be busy for seconds. The worker asks that thread for a sign
in its turn, and says nothing here while it stays out for too long (frontend/src/live/presence/presence.ts).
"""

import asyncio
import contextlib
from typing import Annotated

from fastapi import APIRouter, WebSocket
from pydantic import ValidationError
from starlette.websockets import WebSocketDisconnect

from controller.errors import sentence
from controller.system.tasks import until_one_ends
from server.access.sessions import GivenSessions
from server.http.answers import refusal
from server.http.given import given
from server.http.rates import POLICY, Verdict
from server.http.who import Me
from server.live.hub import Viewer
from server.live.messages import Heard
from server.live.socket_handler import SocketContext
from server.operate.messages import Presence

router = APIRouter()

MESSAGE_MAX_CHARS = 64
"""Longest message of a worker [characters]."""


@router.websocket("/ws/presence/{page}")
async def presence(
    socket: WebSocket,
    page: str,
    context: Annotated[SocketContext, given(SocketContext)],
    sessions: GivenSessions,
    who: Me,
) -> None:
    """Signs of the page that `Hello` named so, until its live socket or session ends, or its worker opens another."""
    viewer = context.pages.named(page, who)
    if viewer is None:
        return await socket.send_denial_response(refusal(404, "no page of this session has a live socket of this name"))
    over = viewer.another_worker()
    await socket.accept()
    await until_one_ends(_listen(socket, viewer, context), _until(over), sessions.ended(who))
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(POLICY)


async def _until(over: asyncio.Event) -> None:
    await over.wait()


async def _listen(socket: WebSocket, viewer: Viewer, context: SocketContext) -> None:
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        verdict = context.rates.message(viewer.who.client)
        if verdict == Verdict.FLOOD:
            return
        if verdict != Verdict.HEARD:
            context.refused.messages += 1
            await asyncio.sleep(0)  # what is dropped must not hold up what is not
        elif (n := _number(message.get("text"), viewer, context)) is None:
            return
        else:
            context.presence(viewer, n)
            await socket.send_text(Heard(n=n).model_dump_json())


def _number(text: str | None, viewer: Viewer, context: SocketContext) -> int | None:
    """The number of a sign; None for anything else, which is told in the log and ends the socket."""
    if text is not None and len(text) <= MESSAGE_MAX_CHARS:
        try:
            return Presence.model_validate_json(text).n
        except ValidationError as error:
            why = sentence(error)
    else:
        why = f"a sign is text of at most {MESSAGE_MAX_CHARS} characters"
    context.refused.messages += 1
    context.control.events.refused(viewer.who.name, "presence", why)
    return None
