"""The live socket's upward half: presence, targets, pings. What is malformed is refused, and the socket goes on."""

import asyncio
import contextvars
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial

from pydantic import TypeAdapter, ValidationError
from pydantic_core import from_json

from controller.errors import TendrilError, sentence
from controller.schema.messages import CommandReply
from server.http.answers import RefusedCounts
from server.http.rates import POLICY, Rates, Verdict
from server.live.hub import Viewer
from server.live.messages import FromBrowser, Ping, Pong, Reply
from server.operate.messages import EStop, Presence, Refused, Release, Target
from server.operate.pages import Pages
from server.operate.target_control import TargetContext, TargetControl
from server.plots.messages import PlotChoice
from server.rig.channels import columns_of

MESSAGE_MAX_CHARS = 4096
"""Longest message from a page."""
STOP_MAX_BYTES = 200
"""Longest message that may be an E-STOP: what is not counted must be cheap."""
_MESSAGE: TypeAdapter[FromBrowser] = TypeAdapter(FromBrowser)


@dataclass(frozen=True)
class SocketContext:
    """What is needed to act on what pages say."""

    control: TargetContext
    pages: Pages[Viewer]
    rates: Rates
    refused: RefusedCounts

    def presence(self, viewer: Viewer, n: int) -> None:
        """Only a number that rises, from a page of the lease's holder, is presence."""
        risen, viewer.presence = n > viewer.presence, max(n, viewer.presence)
        self.control.lease.touch(viewer.who)
        if risen and self.control.lease.holds(viewer.who):
            TargetControl(viewer.who, self.control).sign()


class SocketHandler:
    """What one page says, answered through its viewer's outbox."""

    def __init__(self, viewer: Viewer, context: SocketContext) -> None:
        self._viewer, self._client, self._context = viewer, viewer.who.client, context
        self._events, self._target = context.control.events, TargetControl(viewer.who, context.control)
        self._written = ""
        self._variables = contextvars.copy_context()
        self._in_turn = partial(asyncio.get_running_loop().call_soon_threadsafe, context=self._variables)
        """Calls in the event loop, from any thread, as part of this socket for the audit."""

    async def listen(self) -> None:
        """Hear the page until it is gone, or closed because it floods."""
        socket, rates = self._viewer.socket, self._context.rates
        while (message := await socket.receive())["type"] != "websocket.disconnect":
            match rates.message(self._client):
                case Verdict.HEARD:  # an E-STOP was, as it came in
                    self.hear(message.get("text"))
                case Verdict.DROPPED:
                    self._context.refused.messages += 1
                case Verdict.REFUSED:
                    self._refuse(0, "messages", rates.too_many)
                case Verdict.FLOOD:
                    self._refuse(0, "messages", rates.too_many)
                    return await socket.close(POLICY, rates.too_many)
            await asyncio.sleep(0)  # one message, then the others' turn

    def hear(self, text: str | None) -> None:
        """Act on one message; never raises."""
        self._context.control.lease.touch(self._viewer.who)
        if text is None or len(text) > MESSAGE_MAX_CHARS:
            return self._refuse(0, "message", f"a message is text of at most {MESSAGE_MAX_CHARS} characters")
        try:
            message = _MESSAGE.validate_json(text)
        except ValidationError as error:
            return self._refuse(_id(text), "message", sentence(error))
        match message:
            case Ping():
                self._pong(message)
            case Presence():
                self._context.presence(self._viewer, message.n)
            case Target():
                self._aim(message)
            case Release():
                self._target.release(message.hold)
            case EStop():
                self._stop(message)
            case PlotChoice():
                self._plot(message)

    def urgent(self, data: bytes) -> bool:
        """Act on an E-STOP as it comes in, before the messages that wait and whatever their rate; False: it is none."""
        message = stop_in(data)
        if message is not None:
            self._variables.run(self._stop, message)
        return message is not None

    def leave(self) -> None:
        """The page is gone."""
        self._target.leave(followed=any(map(self._viewer.who.is_session, self._context.pages.present())))

    def _pong(self, message: Ping) -> None:
        self._viewer.post(Pong(t=message.t))
        if message.round_trip is not None:
            self._context.pages.hear_round_trip(self._viewer.who, message.round_trip)

    def _plot(self, message: PlotChoice) -> None:
        try:
            self._viewer.feed.choose(columns_of(message.channels), message.since)
        except TendrilError as error:
            return self._refuse(0, "plots", str(error))
        self._viewer.wake.set()

    def _aim(self, message: Target) -> None:
        at = message.x, message.y
        if message.start:
            self._written = ""
        try:
            asked = self._target.press(at) if message.start else self._target.move(at)
        except TendrilError as error:
            return self._refuse(message.id, "target", str(error))
        asked.add_done_callback(partial(self._in_turn, self._answer, message))

    def _stop(self, message: EStop) -> None:
        asked = self._context.control.operator.stop(self._viewer.who.described)
        asked.add_done_callback(partial(self._in_turn, self._stopped, message.n))

    def _stopped(self, n: int, done: "Future[CommandReply]") -> None:
        who, error = self._viewer.who, done.exception()
        if error is not None:
            self._events.refused(who.described, "e-stop", str(error))
            return self._viewer.post(Refused(id=0, detail=str(error), n=n))
        self._events.answered(who.described, "e-stop", done.result())
        self._viewer.post(Reply(id=0, reply=done.result(), n=n))

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
        self._context.refused.messages += 1
        self._write(what, detail)
        self._viewer.post(Refused(id=number, detail=detail))

    def _write(self, what: str, reason: str) -> None:
        """Into the log: once for all moves of a drag that are refused for the same reason."""
        if reason != self._written:
            self._events.refused(self._viewer.who.name, what, reason)
        self._written = reason


def stop_in(data: bytes) -> EStop | None:
    """The E-STOP that this message is, None if it is none; nothing long is looked at."""
    if len(data) > STOP_MAX_BYTES or b"e_stop" not in data:
        return None
    try:
        message = _MESSAGE.validate_json(data)
    except ValidationError:
        return None
    return message if isinstance(message, EStop) else None


def _id(text: str) -> int:
    """The number of a message that is otherwise malformed, so that the page knows which one was refused."""
    try:
        found = from_json(text)["id"]
    except (ValueError, TypeError, KeyError, IndexError):
        return 0
    return found if isinstance(found, int) and 0 <= found < 2**53 else 0
