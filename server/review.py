"""Slow work for the Review tab, off everyone's path: rerun's viewer extracted, files mended, compacted, measured."""

import logging
import queue
import threading
from collections.abc import Callable
from pathlib import Path

from controller.errors import TendrilError
from recordings.apart import Killed, apart
from recordings.finishing import finish
from recordings.messages import Recording
from recordings.store import Store
from recordings.viewer import viewer_files

log = logging.getLogger(__name__)


class Review:
    """One thread, from the start of the server; `viewer` is None until rerun's files are there."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._stopped: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.viewer: Path | None = None
        self.problem = ""
        threading.Thread(target=self._run, name="review", daemon=True).start()

    def stopped(self, id: str) -> None:
        """A recording is complete: make it quick to open, and measure it."""
        self._stopped.put(id)

    def _run(self) -> None:
        try:
            self.viewer = viewer_files()
        except (TendrilError, OSError) as error:
            self.problem = str(error)
            log.warning("rerun's viewer cannot be served: %s", error)
        self._store.sweep()
        for broken in self._store.broken():
            if not self._improve(self._store.repair, broken):
                self._improve(self._store.check, broken)  # the list says what is wrong with it
            self._finish(broken)
        while True:
            self._finish(self._stopped.get())

    def _finish(self, id: str) -> None:
        """In a process of its own: reading the data would keep this one from serving."""
        try:
            for problem in apart(finish, self._store.folder, id):
                _say(id, problem)
        except Killed as error:
            self._store.sweep()
            _say(id, error)
        except Exception as error:  # whatever is wrong with one, the next ones wait for us
            _say(id, error, unexpected=True)

    def _improve(self, work: Callable[[str], Recording], id: str) -> bool:
        try:
            work(id)
        except (TendrilError, OSError) as error:
            _say(id, error)
            return False
        except Exception as error:  # as above
            _say(id, error, unexpected=True)
            return False
        return True


def _say(id: str, why: object, unexpected: bool = False) -> None:
    log.warning("recording %s stays as it is: %s", id, why, exc_info=unexpected)
