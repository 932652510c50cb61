"""Slow work for the Review tab, off everyone's path: rerun's viewer extracted, files mended, compacted, measured."""

import logging
import queue
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from controller.errors import ProcessKilled, TendrilError
from controller.system.thread import SupervisedThread
from recordings.format.messages import Recording
from recordings.read.viewer import viewer_files
from recordings.store.finishing import check, depict, end_of, finish, repair
from recordings.store.store import Store
from server.http.given import given
from server.recorder.folder import Reader

log = logging.getLogger(__name__)

RECORDING_MAX_S = 600.0
"""For one recording [s]: mending, compacting and measuring 1 GB takes a minute or two."""

END, MEND, FINISH, DEPICT = range(4)
"""What is to be done: the thread ends, or something with a recording; the first first."""


class Review:
    """One thread, from the start of the server; `viewer` is None until rerun's files are there."""

    def __init__(self, store: Store, reader: Reader) -> None:
        self._store, self._reader = store, reader
        self._asked: queue.PriorityQueue[tuple[int, str]] = queue.PriorityQueue()
        self._depicted: set[str] = set()
        self._interrupted: Recording | None = None
        self.viewer: Path | None = None
        self.problem = ""
        self.worker = SupervisedThread("review", self._run, RECORDING_MAX_S)
        self.worker.start()

    def take_interrupted(self) -> Recording | None:
        """What the server before this one was writing when it was killed, once, as soon as that is known."""
        found, self._interrupted = self._interrupted, None
        return found

    def end_of(self, interrupted: Recording) -> tuple[int, int | None]:
        """The rig's boot that it is of, and its last tick; RecordingError where it was deleted meanwhile."""
        return self._reader.call(end_of, self._store.path(interrupted.id))

    def stopped(self, id: str) -> None:
        """A recording is complete: make it quick to open, and measure it."""
        self._asked.put((FINISH, id))

    def cut_off(self, id: str) -> None:
        """The process that wrote a recording was killed: mend it first."""
        self._asked.put((MEND, id))

    def depict(self, ids: Iterable[str]) -> None:
        """Those are shown without a picture: make them, once what has just ended is done."""
        for id in set(ids) - self._depicted:
            self._depicted.add(id)
            self._asked.put((DEPICT, id))

    def close(self) -> None:
        """End once what is being done is done; nobody waits for it, and the next server goes on with the rest."""
        self._asked.put((END, ""))
        self.worker.stop(0.0)

    def _run(self) -> None:
        """Everything that looks at the folder of recordings: a start never waits for it."""
        left = self._left()
        try:
            self.viewer = viewer_files()
        except (TendrilError, OSError) as error:
            self.problem = str(error)
            log.warning("rerun's viewer cannot be served: %s", error)
        for broken in left:
            self._mend(broken)
            self.worker.turn()
        while True:
            self.worker.rest()
            work, id = self._asked.get()
            self.worker.turn()
            if work == END:
                return
            if work == MEND:
                self._mend(id)
            elif work == FINISH:
                self._finish(id)
            else:
                with suppress(TendrilError, OSError):  # gone meanwhile, or its folder takes nothing
                    self._reader.call(depict, self._store.folder, id)

    def _left(self) -> tuple[str, ...]:
        """What killed processes left behind: drafts, which go, and recordings, of which the newest may go on."""
        try:
            self._store.sweep()
            newest, broken = next(iter(self._store.list()), None), self._store.broken()
        except Exception:  # whatever lies in the folder, new recordings wait for us
            log.exception("what is left in %s stays as it is", self._store.folder)
            return ()
        self._interrupted = newest if newest and newest.id in broken else None
        return broken

    def _finish(self, id: str) -> None:
        try:
            for problem in self._reader.call(finish, self._store.folder, id):
                _say(id, problem)
        except ProcessKilled as error:
            self._store.sweep()
            _say(id, error)
        except Exception as error:  # whatever is wrong with one, the next ones wait for us
            _say(id, error, unexpected=True)

    def _mend(self, id: str) -> None:
        """Give it the end that a killed writer could not write, and finish it."""
        try:
            self._reader.call(repair, self._store.folder, id)
        except Exception as error:  # as above
            _say(id, error, unexpected=not isinstance(error, TendrilError | OSError))
            with suppress(Exception):  # what is wrong with it was said already; the list says so, too
                self._reader.call(check, self._store.folder, id)
        else:
            self._finish(id)


def _say(id: str, why: object, unexpected: bool = False) -> None:
    log.warning("recording %s stays as it is: %s", id, why, exc_info=unexpected)


GivenReview = Annotated[Review, given(Review)]
