"""The recorder on the rig's link: it takes every row itself, and servers only ask it.

A server that is killed leaves it at work, and the next one finds it; one that ends in order ends it, if it is the last.
Where none comes back, it ends by itself.
"""

import os
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from multiprocessing import AuthenticationError
from multiprocessing.connection import Connection

from controller.arrays import Rows
from controller.errors import RecordingError, TendrilError
from controller.link import RigClient
from controller.schema.messages import RigInfo
from controller.schema.parameters import Settings
from controller.system.memory import give_back
from recordings.format.annotations import Annotation
from recordings.format.messages import Bookmark, Recording, RecordingState, by_itself
from recordings.live.channel import Message, News, Question, RecorderSettings, Seen, accepted, hang_up, listening
from recordings.write.queue import PRE_TRIGGER_ROWS
from recordings.write.session import Context
from recordings.write.writer import Recorder

LOOK_S, REPEAT_S = 0.05, 1.0
"""Between two looks, and two words to the servers where there is nothing new."""
GONE_S, GONE_BY_ITSELF_S, GONE_BY_HAND_S = 5.0, 60.0, 600.0
"""So long after the last server was killed it ends: where nothing is recorded, where a run or a fault is, and where
a person began it. It is ended whole.
"""
CATCH_UP_S = 10.0
"""Longest wait for a row that a server has seen already."""
AT_ONCE = 8
"""Questions that may wait for the disk."""


class Host:
    """A recorder, its link and its servers. `run` is its life; what servers ask for are its methods of that name."""

    CALLS = ("start", "stop", "mark", "annotate", "bookmarked", "leave")

    def __init__(self, settings: RecorderSettings, refill: bool = False) -> None:
        """OSError where there is such a recorder already. `refill`: the one before was killed, and what came before
        is asked of the rig.
        """
        self._listening = listening(settings)
        self._settings, self._refill = settings, refill
        self._over = threading.Event()
        self._servers: list[Server] = []
        self._ended: deque[Recording] = deque()
        self._seen: Seen | None = None
        self._news_of_row = threading.Condition()
        self._left = time.monotonic()
        self._asked = ThreadPoolExecutor(AT_ONCE, "recorder-asked")
        self.recorder = Recorder(settings.folder, settings.split, self._ended.append, settings.patience)
        self._link = RigClient(
            settings.endpoint, settings.rig, self._take, key=settings.key, tls=settings.tls, commands=False
        )
        threading.Thread(target=self._accept, name="recorder-servers", daemon=True).start()

    def run(self) -> None:
        """Until the last server has left in order, or none has been there for long, or `end`."""
        told = time.monotonic()
        before = None
        while not self._over.wait(LOOK_S) and not self._abandoned():
            self.recorder.look()
            news = self.news()
            if news != before or self._ended or time.monotonic() - told >= REPEAT_S:
                before, told = news, time.monotonic()
                self._tell()
        self.close()

    def end(self) -> None:
        """End it in order, from any thread."""
        self._over.set()

    def close(self) -> None:
        """End recording and link."""
        self._hide()
        self._link.close()
        self.recorder.close()
        for server in tuple(self._servers):
            server.close()
        self._asked.shutdown(wait=False)

    def news(self) -> News:
        """How things stand."""
        recorder = self.recorder
        return News(recorder.state(), recorder.running, recorder.worker.trouble, os.getpid())

    def start(
        self, name: str, info: RigInfo, settings: Settings, context: Context, seen: Seen | None
    ) -> RecordingState:
        """As of `Recorder`, with what the rig's ring holds of the time before it where we do not have that."""
        self._catch_up(seen)
        return self.recorder.start(name, info, settings, replace(context, earlier=self._earlier(context)))

    def stop(self, seen: Seen | None) -> Recording:
        """As of `Recorder`."""
        self._catch_up(seen)
        return self.recorder.stop()

    def mark(self, label: str, seen: Seen | None) -> tuple[str, Bookmark]:
        """As of `Recorder`."""
        self._catch_up(seen)
        return self.recorder.mark(label)

    def annotate(self, annotation: Annotation) -> None:
        """As of `Recorder`."""
        self.recorder.annotate(annotation)

    def bookmarked(self, recording: Recording) -> None:
        """As of `Recorder`."""
        self.recorder.bookmarked(recording)

    def leave(self, seen: Seen | None) -> bool:
        """A server ends in order: so does the recorder, unless another one is here. Whether it does."""
        if len(self._servers) > 1:
            return False
        self._hide()
        self._catch_up(seen)
        self.recorder.close()
        return True

    def _hide(self) -> None:
        """A server that needs a recorder from now on starts another one."""
        with suppress(OSError):  # who waits in `accept` does not hear of a mere close
            self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()

    def _take(self, rows: Rows) -> None:
        self.recorder.rows(rows)
        with self._news_of_row:
            info = self._link.info
            self._seen = Seen(info.boot if info else 0, int(rows["tick"][-1]))
            self._news_of_row.notify_all()

    def _catch_up(self, seen: Seen | None) -> None:
        """Wait for the row that who asks has seen; not for long, as its rig may be gone since."""
        if seen is not None:
            with self._news_of_row:
                self._news_of_row.wait_for(lambda: self._seen is not None and self._has(seen, self._seen), CATCH_UP_S)

    @staticmethod
    def _has(wanted: Seen, seen: Seen) -> bool:
        return seen.boot == wanted.boot and seen.tick >= wanted.tick

    def _earlier(self, context: Context) -> Rows | None:
        if self._seen is None:
            return None
        stop = self._seen.tick + 1
        if context.part_of:
            return None if context.after is None else self._replayed(context.after + 1, stop)
        return self._replayed(max(0, stop - PRE_TRIGGER_ROWS), stop) if self._refill else None

    def _replayed(self, first: int, stop: int) -> Rows | None:
        try:
            return self._link.replay_all(first, stop)
        except TendrilError as error:
            raise RecordingError(f"what came before is not known: {error}") from error

    def _abandoned(self) -> bool:
        if self._servers:
            self._left = time.monotonic()
        running, most = self.recorder.running, GONE_S
        if running:
            most = GONE_BY_ITSELF_S if by_itself(running) else GONE_BY_HAND_S
        return time.monotonic() - self._left > most

    def _message(self, ended: Recording | None) -> Message:
        return Message(self.news(), ended=ended)

    def _tell(self) -> None:
        servers = tuple(self._servers)
        for server in servers:
            ended = self._ended.popleft() if server is servers[0] and self._ended else None
            server.send(partial(self._message, ended))
        give_back()

    def _accept(self) -> None:
        while True:
            try:
                theirs, _ = self._listening.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(theirs,), name="recorder-server", daemon=True).start()

    def _serve(self, theirs: socket.socket) -> None:
        try:
            server = Server(accepted(theirs, self._settings.key))
        except (OSError, EOFError, AuthenticationError):
            return
        left = not self._servers and self.recorder.state().recording
        server.send(lambda: Message(self.news(), left=left))
        self._servers.append(server)
        try:
            for question in server.questions():
                self._hear(server, question)
        finally:
            self._servers.remove(server)
            server.close()

    def _hear(self, server: "Server", question: Question) -> None:
        """What has an answer may wait for the disk; all else is done at once, in order."""
        if question.name not in self.CALLS:
            raise ValueError(question.name)
        if question.number is None:
            getattr(self, question.name)(*question.arguments)
        else:
            self._asked.submit(self._answer, server, question)

    def _answer(self, server: "Server", question: Question) -> None:
        result, wrong = None, None
        try:
            result = getattr(self, question.name)(*question.arguments)
        except Exception as error:
            wrong = error if isinstance(error, TendrilError) else RecordingError(f"{type(error).__name__}: {error}")
        server.send(lambda: Message(self.news(), question.number, result, wrong))
        if question.name == "leave":
            server.close()
            if result:
                self.end()


class Server:
    """One server that asks. Its connection takes messages from any thread."""

    def __init__(self, connection: Connection) -> None:
        self._connection, self._sending = connection, threading.Lock()

    def send(self, made: Callable[[], Message]) -> None:
        """The message, made as it leaves: none tells what is older than the one before it.

        A server that takes nothing in has no connection any more.
        """
        with self._sending:
            try:
                self._connection.send(made())
            except OSError:
                hang_up(self._connection)

    def questions(self) -> Iterator[Question]:
        """What it asks until it is gone, or `close`."""
        with self._connection, suppress(EOFError, OSError):
            while True:
                yield self._connection.recv()

    def close(self) -> None:
        """End the connection."""
        hang_up(self._connection)
