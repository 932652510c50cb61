"""The presence socket: signs of an open page, from a worker of it that a busy main thread does not hold up.

The live socket belongs to the page's main thread, which may be busy for seconds. The worker asks that thread for a sign
in its turn, and says nothing here while it stays out for too long (frontend/src/live/presence/presence.ts).
"""

import asyncio
import contextlib

from fastapi import APIRouter, WebSocket
from pydantic import ValidationError
from starlette.websockets import WebSocketDisconnect

from controller.errors import sentence
from server.answers import refusal
from server.deps import Me, Parts
from server.live import Viewer
from server.messages import Heard, Presence
from server.rates import POLICY, Verdict
from server.services import Services
from server.tasks import until_one_ends

router = APIRouter()

LONGEST = 64
"""Longest message of a worker [characters]."""


@router.websocket("/ws/presence/{page}")
async def presence(socket: WebSocket, page: str, parts: Parts, who: Me) -> None:
    """Signs of the page that `Hello` named so, until its live socket or session ends, or its worker opens another."""
    viewer = parts.hub.page(page, who)
    if viewer is None:
        return await socket.send_denial_response(refusal(404, "no page of this session has a live socket of this name"))
    over = viewer.another_worker()
    await socket.accept()
    await until_one_ends(_listen(socket, viewer, parts), _until(over), parts.sessions.ended(who))
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(POLICY)


def hear_presence(viewer: Viewer, n: int, parts: Services) -> None:
    """Only a number that rises, from a page of the lease's holder, is presence."""
    risen, viewer.presence = n > viewer.presence, max(n, viewer.presence)
    parts.lease.touch(viewer.who)
    if risen and parts.lease.holds(viewer.who):
        parts.operator.present(parts.permits.operator(viewer.who))


async def _until(over: asyncio.Event) -> None:
    await over.wait()


async def _listen(socket: WebSocket, viewer: Viewer, parts: Services) -> None:
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        verdict = parts.rates.message(viewer.who.id)
        if verdict == Verdict.FLOOD:
            return
        if verdict != Verdict.HEARD:
            parts.refused.messages += 1
            await asyncio.sleep(0)  # what is dropped must not hold up what is not
        elif (n := _number(message.get("text"), viewer, parts)) is None:
            return
        else:
            hear_presence(viewer, n, parts)
            await socket.send_text(Heard(n=n).model_dump_json())


def _number(text: str | None, viewer: Viewer, parts: Services) -> int | None:
    """The number of a sign; None for anything else, which is told in the log and ends the socket."""
    if text is not None and len(text) <= LONGEST:
        try:
            return Presence.model_validate_json(text).n
        except ValidationError as error:
            why = sentence(error)
    else:
        why = f"a sign is text of at most {LONGEST} characters"
    parts.refused.messages += 1
    parts.events.refused(viewer.who.name, "presence", why)
    return None
