"""What latches outlives its process: E_STOP and FAULT are kept in a file beside the rig's key, until a CLEAR ends them.

The file is written whole, on the disk, by a thread of its own: a disk that hangs holds up neither loop nor pump.
"""

import logging
import threading
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from controller.errors import sentence
from controller.schema.messages import Latched
from controller.schema.modes import Cause, Mode
from controller.schema.states import LATCHED
from controller.system.thread import SupervisedThread
from controller.system.whole_file import is_regular, read_whole, set_aside, sync_folder, write_whole

log = logging.getLogger(__name__)

AGAIN_S = 1.0
"""Pause before what could not be written is tried again."""
END_MAX_S = 2.0
"""Longest wait for the disk at the end."""


class Latch:
    """One rig's. `kept` is what it is latched by, None while it is not; thread safe."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.kept = read_latch(path)
        self._written: Latched | None = None
        self.trouble = ""
        """Why the newest is not on the disk, "" where it is."""
        self._cleared = -1
        """The tick that acted on the last CLEAR: older rows latch nothing."""
        self._closed = False
        self._changed = threading.Condition()
        self.worker = SupervisedThread("latch", self._run)
        self.worker.start()

    def look(self, row: np.void | None, by: str = "") -> None:
        """Keep what `row` of the telemetry is latched by; `by` names who asked for it."""
        if row is None or row["mode"] not in LATCHED:
            return
        mode, cause = Mode(row["mode"]), Cause(row["cause"])
        with self._changed:
            kept = self.kept
            known = kept is not None and (kept.mode, kept.cause) == (mode, cause) and (kept.by or not by)
            if not known and row["tick"] > self._cleared:
                self.kept = Latched(mode=mode, cause=cause, by=by, at=datetime.now(UTC))
                self._changed.notify_all()

    def clear(self, row: np.void) -> None:
        """The tick of `row` acted on a CLEAR."""
        with self._changed:
            self.kept, self._cleared = None, int(row["tick"])
            self._changed.notify_all()

    def on_disk(self, timeout: float) -> str:
        """Wait until the newest is on the disk; why it is not yet, "" where it is."""
        with self._changed:
            if self._changed.wait_for(lambda: self._done or self.trouble, timeout) and self._done:
                return ""
            return self.trouble or "the disk does not answer"

    def close(self) -> None:
        """End, once what is kept is on the disk."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self.worker.stop(END_MAX_S)

    @property
    def _done(self) -> bool:
        return self._written is self.kept

    def _run(self) -> None:
        while True:
            self.worker.rest()
            with self._changed:
                if self.trouble:
                    self._changed.wait(AGAIN_S)
                self._changed.wait_for(lambda: self._closed or not self._done)
                if self._closed and (self._done or self.trouble):
                    return
                newest = self.kept
            self.worker.turn()
            trouble = self._put(newest)
            with self._changed:
                self.trouble = trouble
                if not trouble:
                    self._written = newest
                self._changed.notify_all()

    def _put(self, newest: Latched | None) -> str:
        """Why it could not be put on the disk, "" once it is."""
        if not is_regular(self._path):
            set_aside(self._path)
        try:
            if newest is None:
                self._path.unlink(missing_ok=True)
                sync_folder(self._path.parent)
            else:
                write_whole(self._path, newest.model_dump_json())
        except OSError as error:
            why = f"{self._path} cannot be written: {error.strerror}"
            if why != self.trouble:
                log.error("the rig's latch would not outlive this process: %s", why)
            return why
        return ""


def latch_path(key_file: Path, rig: str) -> Path:
    """Where a rig's latch lies: beside its key, which is as lasting, and as much its user's own."""
    return key_file.with_name(f"{rig}.latch.json")


def read_latch(path: Path) -> Latched | None:
    """What an earlier process left latched, None for nothing; E_STOP for a file that cannot be understood."""
    try:
        return Latched.model_validate_json(read_whole(path))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        why = sentence(error) if isinstance(error, ValidationError) else str(error)
        log.error("%s cannot be used, so the rig begins in E_STOP; CLEAR ends it: %s", path, why)
        return Latched(mode=Mode.E_STOP, cause=Cause.START, at=datetime.now(UTC))
