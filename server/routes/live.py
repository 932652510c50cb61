"""The live socket's upward half: presence, targets, pings. What is malformed is refused, and the socket goes on."""

import asyncio
import contextlib
import contextvars
from concurrent.futures import Future

from fastapi import APIRouter, WebSocket
from pydantic import TypeAdapter, ValidationError
from pydantic_core import from_json
from starlette.websockets import WebSocketDisconnect

from controller.errors import TendrilError, sentence
from controller.schema.layout import fields
from controller.schema.messages import CommandReply, Telemetry
from controller.schema.modes import Mode, Request
from server.audit import tell
from server.auth import Identity
from server.channels import CHANNELS, columns_of
from server.connections import URGENT
from server.deps import Me, Parts
from server.live import Crowded, Viewer
from server.messages import EStop, FromBrowser, Hello, Ping, Pong, Presence, Refused, Release, Reply, Target
from server.plots.feed import Feed
from server.plots.messages import PlotChoice
from server.problems import answer
from server.rates import POLICY, Verdict
from server.routes.presence import hear_presence
from server.services import Services
from server.tasks import until_one_ends

router = APIRouter()

LONGEST = 4096
"""Longest message from a page [characters]."""
STOP_LONGEST = 200
"""Longest message that may be an E-STOP [bytes]: what is not counted must be cheap."""
_MOVED = (Mode.HOLD, Mode.FOLLOW)
"""HOLD too: the newest row may be older than the press."""
_MESSAGE: TypeAdapter[FromBrowser] = TypeAdapter(FromBrowser)


@router.get("/api/live", status_code=204, tags=["session"])
async def may_look_on(parts: Parts, who: Me) -> None:
    """Whether a page may open /ws/live now; 503 when too many look on. A browser hides why its socket was refused."""
    with parts.hub.seat(who):
        pass


@router.websocket("/ws/live")
async def live(socket: WebSocket, parts: Parts, who: Me) -> None:
    """Hello with the log so far, then everything live, until either side closes; 503 when too many look on."""
    try:
        with parts.hub.seat(who):
            await _serve(socket, parts, who)
    except Crowded as error:
        await socket.send_denial_response(answer(error))


async def _serve(socket: WebSocket, parts: Services, who: Identity) -> None:
    await socket.accept()
    viewer = Viewer(socket, who, Feed(parts.plots))
    await socket.send_text(_hello(parts, viewer).model_dump_json())
    conversation = Conversation(viewer, parts)
    socket.scope["state"][URGENT] = conversation.urgent
    await until_one_ends(parts.hub.serve(viewer), _listen(conversation), parts.sessions.ended(who))
    conversation.leave()
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(1008)


class Conversation:
    """What one page says, answered through its viewer's outbox."""

    def __init__(self, viewer: Viewer, parts: Services) -> None:
        self._viewer, self._parts = viewer, parts
        self._written = ""
        self._loop = asyncio.get_running_loop()
        self._context = contextvars.copy_context()

    def hear(self, text: str | None) -> None:
        """Act on one message; never raises."""
        self._parts.lease.touch(self._viewer.who)
        if text is None or len(text) > LONGEST:
            return self._refuse(0, "message", f"a message is text of at most {LONGEST} characters")
        try:
            message = _MESSAGE.validate_json(text)
        except ValidationError as error:
            return self._refuse(_id(text), "message", sentence(error))
        match message:
            case Ping():
                self._pong(message)
            case Presence():
                hear_presence(self._viewer, message.n, self._parts)
            case Target():
                self._aim(message)
            case Release():
                self._let_go(message)
            case EStop():
                self._stop(message)
            case PlotChoice():
                self._plot(message)

    def urgent(self, data: bytes) -> bool:
        """Act on an E-STOP as it comes in, before the messages that wait and whatever their rate; False: it is none."""
        message = stop_in(data)
        if message is not None:
            self._context.run(self._stop, message)
        return message is not None

    def leave(self) -> None:
        """The page is gone. Another tab of its session stays present, but nobody there began this motion: hold it."""
        parts, who, driver = self._parts, self._viewer.who, self._parts.hub.driver
        if driver is not self._viewer:
            return
        parts.hub.driver = None
        alone = all(other.who.id != who.id for other in parts.hub.viewers)
        newest = parts.history.newest
        if not alone and parts.lease.holds(who) and newest is not None and newest[0]["mode"] in _MOVED:
            parts.operator.request(Request.HOLD, parts.permits.operator(who))
            parts.events.add(f"{who.name}: the tab that moved the target was closed: hold")

    def verdict(self) -> Verdict:
        """Whether the message that came is heard; an E-STOP was, as it came in."""
        found = self._parts.rates.message(self._viewer.who.id)
        self._parts.refused.messages += found == Verdict.DROPPED  # the others are counted as they are told
        return found

    def hurried(self) -> str:
        """Say that messages are dropped, and why."""
        self._refuse(0, "messages", why := self._parts.rates.too_many)
        return why

    def _pong(self, message: Ping) -> None:
        self._viewer.post(Pong(t=message.t))
        if message.round_trip is not None and self._parts.lease.holds(self._viewer.who):
            self._parts.alarm_watch.hear_round_trip(message.round_trip)

    def _plot(self, message: PlotChoice) -> None:
        try:
            self._viewer.feed.choose(columns_of(message.channels), message.since)
        except TendrilError as error:
            return self._refuse(0, "plots", str(error))
        self._viewer.wake.set()

    def _aim(self, message: Target) -> None:
        if message.start:
            self._written = ""
        try:
            permit = self._parts.permits.operator(self._viewer.who)
        except TendrilError as error:
            return self._refuse(message.id, "target", str(error))
        operator, at = self._parts.operator, (message.x, message.y)
        operator.present(permit)
        if message.start:
            self._parts.hub.driver = self._viewer
            tell(f"follow, target at ({message.x:.4f}, {message.y:.4f}) m")
        asked = operator.request(Request.FOLLOW, permit, at) if message.start else operator.move(at, permit)
        asked.add_done_callback(
            lambda done: self._loop.call_soon_threadsafe(self._answer, message, done, context=self._context)
        )

    def _let_go(self, message: Release) -> None:
        lease = self._parts.lease
        if (lease.clutch or message.hold) and lease.holds(self._viewer.who):
            self._parts.operator.request(Request.HOLD, self._parts.permits.operator(self._viewer.who))
            tell("the plan moved under the drag: hold" if message.hold else "target let go: hold")

    def _stop(self, message: EStop) -> None:
        asked = self._parts.operator.stop()
        asked.add_done_callback(
            lambda done: self._loop.call_soon_threadsafe(self._stopped, message.n, done, context=self._context)
        )

    def _stopped(self, n: int, done: "Future[CommandReply]") -> None:
        who, error = self._viewer.who, done.exception()
        if error is not None:
            self._parts.events.refused(who.name, "e-stop", str(error))
            return self._viewer.post(Refused(id=0, detail=str(error), n=n))
        reply = done.result()
        if reply.accepted:
            self._parts.events.done(who.name, "e-stop")
        else:
            self._parts.events.refused(who.name, "e-stop", reply.detail)
        self._viewer.post(Reply(id=0, reply=reply, n=n))

    def _answer(self, message: Target, done: "Future[CommandReply]") -> None:
        error = done.exception()
        if error is not None:
            return self._refuse(message.id, "target", str(error))
        reply = done.result()
        if reply.accepted:
            self._written = ""
        else:
            self._write("follow" if message.start else "target", reply.detail)
        self._viewer.post(Reply(id=message.id, reply=reply))

    def _refuse(self, number: int, what: str, detail: str) -> None:
        self._parts.refused.messages += 1
        self._write(what, detail)
        self._viewer.post(Refused(id=number, detail=detail))

    def _write(self, what: str, reason: str) -> None:
        """Into the log: once for all moves of a drag that are refused for the same reason."""
        if reason != self._written:
            self._parts.events.refused(self._viewer.who.name, what, reason)
        self._written = reason


async def _listen(conversation: Conversation) -> None:
    socket = conversation._viewer.socket
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        match conversation.verdict():
            case Verdict.HEARD:
                conversation.hear(message.get("text"))
            case Verdict.REFUSED:
                conversation.hurried()
            case Verdict.FLOOD:
                return await socket.close(POLICY, conversation.hurried())
        await asyncio.sleep(0)  # one message, then the others' turn


def stop_in(data: bytes) -> EStop | None:
    """The E-STOP that this message is, None if it is none; nothing long is looked at."""
    if len(data) > STOP_LONGEST or b"e_stop" not in data:
        return None
    try:
        message = _MESSAGE.validate_json(data)
    except ValidationError:
        return None
    return message if isinstance(message, EStop) else None


def _hello(parts: Services, viewer: Viewer) -> Hello:
    session, log = parts.session(viewer.who), list(parts.events.recent)
    return Hello(
        session=session, layout=fields(Telemetry), channels=CHANNELS, page=viewer.page, rig=parts.rig.info, log=log
    )


def _id(text: str) -> int:
    """The number of a message that is otherwise malformed, so that the page knows which one was refused."""
    try:
        found = from_json(text)["id"]
    except (ValueError, TypeError, KeyError, IndexError):
        return 0
    return found if isinstance(found, int) and 0 <= found < 2**53 else 0
