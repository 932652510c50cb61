"""The log: who did what, what was refused, what the rig did by itself. Kept for those who come later, told to all."""

import logging
from collections import deque
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Annotated, Literal

from fastapi import Request
from pydantic import BaseModel

from controller.schema.layout import Model
from controller.schema.messages import CommandReply
from controller.schema.modes import Cause, Mode
from recordings.format.messages import Level
from server.http.given import given, part_of
from server.http.rates import LINE, Bucket, Rate
from server.log.audit import tell
from server.log.event_file import EventFile
from server.log.line_writer import LineWriter

REPEATED = timedelta(minutes=10)
"""What is said about the same subject again within this time takes the place of the line before."""
MUTED = Rate("notes of lines left out", 1, 1 / 60)


log = logging.getLogger(__name__)

_READING = ("GET", "HEAD", "OPTIONS")
_LONGEST = 200
"""Characters of a reason that are kept: it may quote what a stranger sent."""
_NAME = 40


class LogEntry(Model):
    """One line of the log: who did what, and what was refused."""

    type: Literal["event"] = "event"
    time: datetime
    level: Level
    text: str
    subject: str = ""
    """What may be said again and again, an alarm for instance; "" for anything else."""
    count: int = 1
    """How many times in a row it was said; from 2 on this line takes the place of the one before it."""


def to_log(event: LogEntry) -> None:
    """A listener: the process's own log gets every line too."""
    log.log(logging.getLevelNamesMapping()[event.level.upper()], "%s", event.text)


class EventLog:
    """The last lines and their listeners, which hear of each in the event loop; nothing waits for the disk.

    With a file the lines outlive the server.
    """

    def __init__(
        self,
        file: EventFile[LogEntry] | None = None,
        kept: int = 500,
        in_turn: Callable[[Callable[[], object]], object] = lambda call: call(),
    ) -> None:
        """`in_turn` makes a call in the event loop: at once where it is asked for there."""
        self._in_turn = in_turn
        self.recent: deque[LogEntry] = deque(_counted_up(file.last() if file else []), maxlen=kept)
        self._listeners: list[Callable[[LogEntry], None]] = []
        self.writer = LineWriter(file, "event log", "the log will not outlive this server") if file else None
        self._lines, self._muted = Bucket(LINE), Bucket(MUTED)

    def listen(self, listener: Callable[[LogEntry], None]) -> None:
        """Give every line from now on to `listener` too."""
        self._listeners.append(listener)

    def add(self, text: str, level: Level = "info", subject: str = "") -> None:
        """Write a line and tell the listeners, and the audit of what it is part of; of a `subject` they are counted.
        From any thread.
        """
        plain = text.encode(errors="backslashreplace").decode()  # it may quote bytes that are not Unicode
        tell(plain)
        self._in_turn(partial(self._write, plain, level, subject, datetime.now(UTC)))

    def _write(self, text: str, level: Level, subject: str, now: datetime) -> None:
        event = LogEntry(time=now, level=level, text=text, subject=subject, count=self._count(subject, now))
        _take_place(self.recent, event)
        for listener in self._listeners:
            try:
                listener(event)
            except Exception:  # who does not take a line must not keep it from the others
                log.exception("a line of the log was not passed on")
        if self.writer is not None:
            self.writer.append(event)

    def _count(self, subject: str, now: datetime) -> int:
        before = _about(self.recent, subject)
        return before.count + 1 if before is not None and now - before.time <= REPEATED else 1

    def answered(self, name: str, asked: str, reply: CommandReply) -> None:
        """The rig answered what `name` asked for."""
        if reply.accepted:
            self.done(name, asked)
        else:
            self.refused(name, asked, reply.detail)

    def look(self) -> None:
        """A job: say what became of the file."""
        if self.writer is not None and (news := self.writer.news()):
            self.add(news, "warning")

    def done(self, who: str, what: str) -> None:
        """Write what `who` did, which anybody may as often as he likes, unless that would fill the log."""
        self._add_of(who, f"{who}: {what}", "info", "done")

    def refused(self, who: str, what: str, reason: str) -> None:
        """Write that `who` asked for `what` in vain, unless that would fill the log."""
        self._add_of(who, f"{who}: {what} refused: {reason}", "warning", "refused")

    def _add_of(self, who: str, text: str, level: Level, kind: str) -> None:
        if not self._lines.wait(who):
            self.add(text, level)
        elif not self._muted.wait(who):
            self.add(f"{who}: more is {kind} than is written here", "warning")


def _about(lines: Iterable[LogEntry], subject: str) -> LogEntry | None:
    """The last of them about `subject`."""
    return next((line for line in reversed([*lines]) if subject and line.subject == subject), None)


def _take_place(lines: deque[LogEntry], event: LogEntry) -> None:
    """Append, in the place of the line that it counts on."""
    before = _about(lines, event.subject)
    if before is not None and event.count == before.count + 1:
        lines.remove(before)
    lines.append(event)


def _counted_up(lines: Iterable[LogEntry]) -> deque[LogEntry]:
    found: deque[LogEntry] = deque()
    for line in lines:
        _take_place(found, line)
    return found


GivenEvents = Annotated[EventLog, given(EventLog)]


def words(member: Mode | Cause) -> str:
    """A mode or a cause as people read it."""
    return member.name.replace("_", " ").lower() if isinstance(member, Cause) else member.name.replace("_", "-")


class _Asked(BaseModel):
    """The part of a command's body that names it, right or wrong."""

    request: str


async def note_refusal(request: Request, reason: str) -> None:
    """Write the refusal of `request` into the log."""
    if request.method in _READING:
        return
    part_of(request, EventLog).refused(_who(request), await _what(request), reason[:_LONGEST])


def _who(request: Request) -> str:
    who = request.state.who
    if who is not None:
        return str(who.name)
    return f"someone at {request.client.host}" if request.client else "someone"


async def _what(request: Request) -> str:
    """The rig's request by its own name, everything else by the name of its route."""
    name: str = request.scope["route"].name
    if name == "command":
        try:
            name = _Asked.model_validate_json(await request.body()).request
        except ValueError:
            pass  # no JSON, or none that names a request
    return name[:_NAME].replace("_", "-" if name == "e_stop" else " ")
