"""The server's end of the recorder, which is a process of its own on the rig's link (`recordings/live/host.py`).

One thread keeps it there and hears how it is; what is asked of it goes out in order by another one.
"""

import itertools
import logging
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError, ThreadPoolExecutor
from contextlib import suppress
from multiprocessing import AuthenticationError
from multiprocessing.connection import Connection
from typing import Annotated, Any, NamedTuple, cast

from controller.errors import RecordingError
from controller.schema.messages import RigInfo
from controller.schema.parameters import Settings
from controller.system.child import launched
from controller.system.logs import logs_json
from controller.system.thread import SupervisedThread
from recordings.format.annotations import Annotation
from recordings.format.messages import Bookmark, Recording, RecordingState
from recordings.live.channel import Message, News, Question, RecorderSettings, Seen, connected
from recordings.write.session import Context
from recordings.write.writer import ENDED
from server.http.given import given
from server.log.events import EventLog

log = logging.getLogger(__name__)

PROGRAM: tuple[str, ...] = ("recordings.live",)
WRITING = "writing recordings"
"""Its name in the list of processes."""
START_S, CONNECT_RETRY_S = 20.0, 0.02
"""Longest wait for its start, and between two tries to reach it."""
ANSWER_S, LEAVE_S = 45.0, 12.0
"""Longest wait for an answer, which may be about a disk that hangs (`writer.ANSWER`), and for the last one."""
SILENT_S = 15.0
"""It says how it is once a second: one that does not for so long, a disk that hangs or not, is ended."""
NOTES_MAX = 500
"""Lines of the log and the like that may wait for it."""
KILLED = "the process that wrote it was killed"
PLAIN = Context()
RECORDER_S = 0.1
"""Between two looks: a disk that hangs is found out by them."""


class Interrupted(NamedTuple):
    """A recording whose process was killed, and whether it was to end just then."""

    recording: Recording
    ending: bool


def launch(settings: RecorderSettings, refill: bool) -> None:
    """Start the recorder of `settings` in a session of its own: it goes on when we are killed."""
    ours, theirs = os.pipe()
    with os.fdopen(ours, "rb"), os.fdopen(theirs, "wb") as given:
        process = launched((*PROGRAM, str(ours), WRITING, settings.rig), None, keep=(ours,))
        pickle.dump((settings, refill, "json" if logs_json() else "text"), given)
    threading.Thread(target=process.wait, name="recorder-end", daemon=True).start()  # no zombie is left


class RecorderClient:
    """As of `recordings.write.writer.Recorder`; its methods may be called from any thread."""

    def __init__(
        self,
        settings: RecorderSettings,
        seen: Callable[[], Seen | None],
        ended: Callable[[Recording], None],
        launch: Callable[[RecorderSettings, bool], None] = launch,
    ) -> None:
        """`seen` is the newest row that we have, and `ended` is told of recordings that ended by themselves, whole."""
        self._settings, self._seen, self._ended, self._launch = settings, seen, ended, launch
        self._news = News(RecordingState(recording=False, id="", seconds=0.0, rows=0, gaps=0), None, "", 0)
        self._connection: Connection | None = None
        self._there, self._closing = threading.Event(), False
        self._asked: dict[int, Future[Any]] = {}
        self._numbers, self._notes = itertools.count(), 0
        self._sender = ThreadPoolExecutor(1, "recorder-asks")
        self._stopping = self._ending = False
        self._problem = self._barred = ""
        self._interrupted: Interrupted | None = None
        self._left: Recording | None = None
        self._met = False
        self.worker = SupervisedThread("recorder", self._work, SILENT_S)
        self.worker.start()

    def start(self, name: str, info: RigInfo, settings: Settings, context: Context = PLAIN) -> RecordingState:
        """Begin a recording with the rows before it; RecordingError when one runs or none may, or of the disk."""
        if self._barred:
            raise RecordingError(self._barred)
        return cast(RecordingState, self._ask("start", name, info, settings, context, self._seen()))

    def bar(self, why: str) -> None:
        """Let no recording begin, and `state` say `why`; "" ends that. One that runs goes on."""
        self._barred = why

    def stop(self) -> Recording:
        """End the recording, whole and closed; RecordingError when none runs, it failed, or the disk hangs."""
        self._stopping = True
        try:
            return cast(Recording, self._ask("stop", self._seen()))
        finally:
            self._stopping = False

    def mark(self, label: str = "") -> tuple[str, Bookmark]:
        """Set a bookmark at the newest row: the recording's id, and the mark for its sidecar; `bookmarked` shows it."""
        return cast(tuple[str, Bookmark], self._ask("mark", label, self._seen()))

    def annotate(self, annotation: Annotation) -> None:
        """Note it in the running recording, if any; it never waits, and is left out behind 500 others."""
        if self._news.state.recording and self._notes < NOTES_MAX:
            self._post("annotate", annotation)

    def bookmarked(self, recording: Recording) -> None:
        """Tell of the bookmarks of `recording` as they are now, if it is the one that runs."""
        self._post("bookmarked", recording)

    def state(self) -> RecordingState:
        """What the recorder does now; `problem` says why none may begin, or why the last one ended by itself."""
        state = self._news.state
        return state.model_copy(update={"problem": self._barred}) if self._barred else state

    def first(self) -> str:
        """Id of the running recording's first part, "" when none runs."""
        running = self._news.running
        return (running.part_of or running.id) if running else ""

    @property
    def pid(self) -> int:
        """Of its process; 0 while there is none."""
        return self._news.pid

    @property
    def trouble(self) -> str:
        """What is wrong with the recorder's own thread, "" if nothing is."""
        return self._news.trouble

    def take_interrupted(self) -> Interrupted | None:
        """The recording that ended because its process was killed, once."""
        found, self._interrupted = self._interrupted, None
        return found

    def take_left(self) -> Recording | None:
        """The recording that goes on though the server that began it was killed, once."""
        found, self._left = self._left, None
        return found

    def close(self) -> None:
        """End the recorder with what it records, unless another server has it, too; once is enough."""
        if self._closing:
            return
        with suppress(RecordingError):
            self._ask("leave", self._seen(), timeout=LEAVE_S, closing=True)
        self._closing = True
        self.worker.stop(1.0)
        self._sender.shutdown(wait=False)

    def _ask(self, name: str, *arguments: Any, timeout: float = ANSWER_S, closing: bool = False) -> Any:
        if not self._there.wait(START_S):
            raise RecordingError("the recorder does not start; the log says why")
        self._closing = self._closing or closing
        answer: Future[Any] = Future()
        number = next(self._numbers)
        self._asked[number] = answer
        try:
            self._sender.submit(self._send, Question(number, name, arguments))
            return answer.result(timeout)
        except (RuntimeError, TimeoutError):
            raise RecordingError("the recorder does not answer") from None
        finally:
            self._asked.pop(number, None)

    def _post(self, name: str, argument: Any) -> None:
        self._notes += 1
        with suppress(RuntimeError):  # we have ended
            self._sender.submit(self._send, Question(None, name, (argument,)))

    def _send(self, question: Question) -> None:
        self._notes -= question.number is None
        try:
            if self._connection is None:
                raise OSError
            self._connection.send(question)
        except OSError:
            if question.number in self._asked:
                self._asked[question.number].set_exception(RecordingError(KILLED))

    def _work(self) -> None:
        """Keep it there, and hear how it is."""
        while not self._closing:
            self.worker.turn()
            with self._reached() as self._connection:
                self._there.set()
                with suppress(EOFError, OSError):
                    self._hear(self._connection)
            self._lose()

    def _reached(self) -> Connection:
        """The connection with the recorder, which is started where there is none."""
        end, started = time.monotonic() + START_S, False
        while True:
            try:
                return connected(self._settings)
            except (ConnectionRefusedError, FileNotFoundError) as error:
                if time.monotonic() > end:
                    raise RecordingError("the recorder does not start") from error
            except (OSError, EOFError, AuthenticationError):  # it just ended
                pass
            if not started:
                started = True
                self._begin()
            self.worker.rest()
            time.sleep(CONNECT_RETRY_S)

    def _hear(self, connection: Connection) -> None:
        while True:
            self.worker.rest()
            if not connection.poll(SILENT_S):
                return self._end_silent()
            self.worker.turn()
            self._take(connection.recv())

    def _take(self, message: Message) -> None:
        self._news = self._with_problem(message.news)
        if message.left and not self._met:
            self._left = message.news.running
        self._met = True
        if message.ended:
            self._ended(message.ended)
        answer = self._asked.get(message.number) if message.number is not None else None
        if answer is not None and message.error:
            answer.set_exception(message.error)
        elif answer is not None:
            answer.set_result(message.result)

    def _with_problem(self, news: News) -> News:
        """How the last recording ended is told until another one begins, though its process is gone."""
        if news.state.recording:
            self._problem = ""
        told = news.state.problem or self._problem
        return news._replace(state=news.state.model_copy(update={"problem": told}))

    def _end_silent(self) -> None:
        if self.pid not in (0, os.getpid()):
            log.error("the recorder has not said anything for %g s: it is ended", SILENT_S)
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)

    def _lose(self) -> None:
        """It hangs up: it has ended, or was left without a word from us for too long."""
        self._there.clear()
        self._connection, self._ending = None, self._stopping
        for answer in list(self._asked.values()):
            with suppress(InvalidStateError):  # answered at the last moment
                answer.set_exception(RecordingError(f"{ENDED}: {KILLED}"))

    def _begin(self) -> None:
        """There is none: it was killed, if it was there already."""
        lost = self._news
        if lost.running:
            self._interrupted, self._problem = Interrupted(lost.running, self._ending), f"{ENDED}: {KILLED}"
        self._news = self._with_problem(News(lost.state.model_copy(update={"recording": False}), None, "", 0))
        self._launch(self._settings, self._met)


GivenRecorder = Annotated[RecorderClient, given(RecorderClient)]


class RecorderWatch:
    """Says once in the log what the recorder's state says is wrong: no one may be looking at it."""

    def __init__(self, recorder: RecorderClient, events: EventLog) -> None:
        self._recorder, self._events = recorder, events
        self._told = ""

    def look(self) -> None:
        """Look once."""
        state = self._recorder.state()
        if state.problem and state.problem != self._told:
            self._events.add(state.problem, "warning" if state.recording else "error")
        elif self._told and state.recording and not state.problem:
            self._events.add(f"recording {state.id} has caught up: nothing waits for the disk")
        self._told = state.problem
