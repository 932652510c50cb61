"""The recorder: every tick that the link delivers goes into an .rrd file, from a thread of its own."""

import contextlib
import queue
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from controller.arrays import Rows
from controller.errors import RecordingError
from controller.schema.layout import copied, record_dtype
from controller.schema.messages import RigInfo, Telemetry
from controller.schema.parameters import Settings
from controller.system.thread import SupervisedThread
from recordings.format import sidecar
from recordings.format.annotations import Annotation
from recordings.format.messages import DISK_TIMEOUT_S, SPLIT_BYTES, Bookmark, Recording, RecordingState
from recordings.write.queue import Job, NoAnswer, RecorderQueue
from recordings.write.session import Context, Session

BATCH_ROWS = 250
BATCH_SECONDS = 0.13
"""A batch is written when it has this many rows or is this old: the most that a killed writer loses."""

POLL_SECONDS = 0.05
PAUSED = 1.0
"""Looks that are further apart tell that this process stood still [s]."""
SLOW_S = 3.0
"""A disk that takes nothing for so long is told [s]."""
ANSWER = 40.0
"""Longest wait for a recording to begin or to end [s]. The end puts all of it on the disk, which may take longer."""
LAST = 10.0
"""The same when the server ends [s]; its parent kills it after 20."""
PLAIN = Context()
FIRST_ROWS = 1000
"""Rows from memory are written in batches of this many."""
ENDED = "the recording ended by itself"
NEVER = -1
"""Before every tick."""


class Recorder:
    """Writes one recording at a time into `folder`. Its methods may be called from any thread."""

    def __init__(
        self,
        folder: Path,
        split: int = SPLIT_BYTES,
        ended: Callable[[Recording], None] = lambda done: None,
        patience: float = DISK_TIMEOUT_S,
    ) -> None:
        """A file that reaches `split` bytes is `ended`, and the recording goes on in another one.

        `patience` [s] is had with a disk that takes nothing; see `look`.
        """
        self._looked = self._awake = time.monotonic()
        self._patience, self._given_up, self._waits = patience, "", ""
        self._ending = self._overdue = False
        """Whether the recording is to end, and whether who asked for that waits no more."""
        self._split_bytes, self._ended = split, ended
        self._queue = RecorderQueue()
        self._folder = folder
        self._running: Recording | None = None
        self._session: Session | None = None
        self._done: Recording | None = None
        """The last one that was ended whole on request."""
        self._state = RecordingState(recording=False, id="", seconds=0.0, rows=0, gaps=0)
        self._pending: list[Rows] = []
        self._pending_since = 0.0
        self.worker = SupervisedThread("recorder", self._run, patience)
        self.worker.start()

    def start(self, name: str, info: RigInfo, settings: Settings, context: Context = PLAIN) -> RecordingState:
        """Begin a recording with the rows before it that are in memory.

        Raises `RecordingError` when one runs already or the disk cannot take it.
        """
        self._require_disk()
        try:
            return self._queue.ask(lambda: self._start(name, info, settings, context), ANSWER)
        except NoAnswer:
            self._queue.later(self._close_unwanted)
            raise

    def rows(self, rows: Rows) -> None:
        """Take telemetry rows (n,) in the order of their ticks. Cheap: they are copied and handed over."""
        if len(rows):
            self._queue.rows(copied(rows))

    def annotate(self, annotation: Annotation) -> None:
        """Note it in the running recording, if any; it never waits, and is left out behind 500 others."""
        if self._queue.is_open:
            self._queue.later(lambda: self._annotate(annotation))

    def mark(self, label: str = "") -> tuple[str, Bookmark]:
        """Set a bookmark at the newest row: the recording's id, and the mark for its sidecar; `bookmarked` shows it.

        RecordingError when none runs, nothing is in it yet, or it has as many as it may.
        """
        self._require_disk()
        return self._queue.ask(lambda: self._mark(label), ANSWER)

    def bookmarked(self, recording: Recording) -> None:
        """Tell of the bookmarks of `recording` as they are now, if it is the one that runs."""
        session = self._session
        if session and session.id == recording.id:
            session.bookmarks = recording.bookmarks  # `state` has them with the next rows

    def stop(self) -> Recording:
        """End the recording, whole and closed; raises `RecordingError` when none runs or it failed.

        NoAnswer of a disk that hangs: then it ends when the disk answers, which is told as of a full file.
        """
        self._require_disk()
        self._queue.is_open, self._ending, id = False, True, self._state.id
        try:
            return self._queue.ask(self._stop, ANSWER)
        except NoAnswer:
            self._overdue = True
            self._queue.later(lambda: self._stop_overdue(id))
            raise

    def look(self) -> None:
        """To be called now and then, from any thread: rows wait in memory for a disk that hangs, which `state` tells.

        One that takes nothing for longer than the patience ends the recording, here and now. The recorder's own thread
        hangs with the disk; it closes what can be closed when it comes back.
        """
        now, before = time.monotonic(), self._looked
        self._looked = now
        if now - before > PAUSED:  # it was us who stood still, not the disk
            self._awake = now
        waited = self._waited(now)
        self._waits = self._slow() if waited > SLOW_S or (self._waits and self._queue.behind) else ""
        if not self._state.recording or self._given_up or (self._ending and not self._overdue):
            return
        if self._queue.full:
            self._give_up("the disk is too slow: ten minutes of rows wait for it")
        elif waited > self._patience:
            self._give_up(f"the disk has taken nothing for {self._patience:g} s")

    def state(self) -> RecordingState:
        """What the recorder does now; `problem` says why rows wait, or why the last recording ended by itself."""
        state, waits = self._state, self._waits
        return state.model_copy(update={"problem": waits}) if waits and state.recording else state

    @property
    def running(self) -> Recording | None:
        """The recording that goes on, as it was described when it began; None when none runs."""
        return self._running if self._state.recording else None

    def close(self) -> None:
        """End a running recording and the recorder's thread."""
        self._queue.is_open = False
        self._queue.end()
        self.worker.stop(LAST)

    def _waited(self, now: float) -> float:
        """For how long the disk has taken nothing [s]; what passed while this process stood still does not count."""
        session = self._session
        return min(now - self._awake, max(self.worker.stuck, session.waiting if session else 0.0))

    def _slow(self) -> str:
        return f"the disk took nothing for {SLOW_S:g} s: rows wait in memory, for {self._patience:g} s at most"

    def _give_up(self, why: str) -> None:
        self._given_up = f"{ENDED}: {why}"
        self._queue.drop()
        self._state = self._session_over(self._given_up)
        self._queue.later(self._close_given_up)

    def _close_unwanted(self) -> None:
        """A recording began after all, when no one waited for it any more."""
        if self._session:
            self._fail(RecordingError("the disk was too slow for it to begin"))

    def _stop_overdue(self, id: str) -> None:
        """No one waited for the end of `id` any more: it comes now, unless it came after all, or was given up."""
        if self._session and self._session.id == id and not self._given_up:
            with contextlib.suppress(RecordingError):  # the state tells it
                self._stop()
        self._ending = self._overdue = False
        if self._done and self._done.id == id:
            self._ended(self._done)

    def _close_given_up(self) -> None:
        if self._session and self._given_up:
            self._fail(RecordingError(self._given_up.removeprefix(f"{ENDED}: ")))
        self._given_up = ""

    def _require_disk(self) -> None:
        if self._given_up or self.worker.stuck > self._patience:
            raise RecordingError("the disk does not answer")

    def _run(self) -> None:
        self.worker.rest()  # rerun's first call takes long on a busy machine: that is no disk that hangs
        self._warm_up()
        while (item := self._next()) is not None:
            self.worker.turn()
            self._guarded(item)
        if self._session:
            self._guarded(self._stop)

    def _warm_up(self) -> None:
        with contextlib.suppress(Exception):  # a full disk, say: the first recording will tell
            from recordings.write.rrd import warm_up  # late: who only names a recorder needs no rerun

            warm_up()

    def _next(self) -> Job | Rows | None:
        """The next thing handed over; writing what is due when nothing is."""
        self.worker.rest()
        try:
            return self._queue.next(POLL_SECONDS if self._pending else None)
        except queue.Empty:
            return self._write_due

    def _guarded(self, item: Job | Rows) -> None:
        """Whatever goes wrong ends the recording, never the thread: the link must not wait for a dead reader."""
        try:
            if isinstance(item, np.ndarray):
                self._pend(item)
            else:
                item()
        except Exception as error:
            self._fail(error)

    def _start(self, name: str, info: RigInfo, settings: Settings, context: Context) -> RecordingState:
        if self._session:
            raise RecordingError(f"recording {self._session.id} is running already")
        rows = self._rows_from_now(context)
        try:
            self._folder.mkdir(sidecar.FOLDER_MODE, parents=True, exist_ok=True)
            self._session = Session(self._folder, name, info, settings, context)
        except (OSError, RecordingError) as error:
            self._queue.drop()
            if isinstance(error, RecordingError):
                raise
            raise RecordingError(f"nothing can be written into {self._folder}: {error}") from error
        try:
            for begin in range(0, len(rows), FIRST_ROWS):
                self._session.write(rows[begin : begin + FIRST_ROWS])
        except Exception as error:
            self._fail(error)
            raise RecordingError(self._state.problem) from error
        self._state, self._running = self._session.state(), self._session.described()
        return self._state

    def _rows_from_now(self, context: Context) -> Rows:
        """What was before; all that comes waits from now on, as the file may take long to be opened."""
        earlier = [] if context.earlier is None or not len(context.earlier) else [context.earlier]
        before = self._queue.open(int(earlier[0]["tick"][-1]) if earlier else NEVER)
        return np.concatenate([*earlier, *before]) if earlier or before else np.empty(0, record_dtype(Telemetry))

    def _stop(self) -> Recording:
        if not self._session:
            self._ending = False
            raise RecordingError(self._state.problem or "no recording is running")
        try:
            self._write_pending()
            done = self._session.end()
        except Exception as error:
            self._fail(error)
            raise RecordingError(self._state.problem) from error
        finally:
            self._ending = False
        self._session, self._done = None, done
        self._state = self._session_over()
        return done

    def _annotate(self, annotation: Annotation) -> None:
        if self._session:
            self._write_pending()
            self._session.annotate(annotation)

    def _mark(self, label: str) -> tuple[str, Bookmark]:
        if not self._session:
            raise RecordingError("no recording is running")
        self._write_pending()
        return self._session.id, self._session.mark(label)

    def _pend(self, rows: Rows) -> None:
        if not self._session or self._given_up:
            return
        if not self._pending:
            self._pending_since = time.monotonic()
        self._pending.append(rows)
        self._write_due()

    def _write_due(self) -> None:
        old = time.monotonic() - self._pending_since >= BATCH_SECONDS
        if old or sum(map(len, self._pending)) >= BATCH_ROWS:
            self._write_pending()

    def _write_pending(self) -> None:
        rows, self._pending = self._pending, []
        if rows and self._session:
            self._session.write(np.concatenate(rows))
            if self._session.bytes >= self._split_bytes:
                self._split(self._session)
            if not self._given_up:
                self._state = self._session.state()

    def _split(self, full: Session) -> None:
        """Close the file and go on in another."""
        done = full.end()
        self._session = None
        self._ended(done)
        self._session = full.next()
        self._running = self._session.described()

    def _fail(self, error: Exception) -> None:
        """End the recording because of `error` and keep the reason for `state`."""
        self._queue.is_open, self._pending = False, []
        session, self._session = self._session, None
        over = self._session_over(f"{ENDED}: {error}")
        if session:
            with contextlib.suppress(Exception):  # the first error is the one that counts
                session.abandon(over.problem)
        self._state = over  # last: who reads it finds file and sidecar closed

    def _session_over(self, problem: str = "") -> RecordingState:
        return self._state.model_copy(update={"recording": False, "problem": problem})
