"""Puts a growing file on the disk twice a second, and then what is said about it: a power cut loses no more than that.

From a thread of its own: a slow disk holds up neither the rows nor the recorder.
"""

import os
import time
from pathlib import Path

from controller.errors import RecordingError
from controller.system.thread import SupervisedThread
from controller.system.whole_file import open_regular
from recordings.format import sidecar
from recordings.format.messages import DISK_TIMEOUT_S, Recording

SYNC_S = 0.5
"""Between two times that the data go to the disk [s]; with the batch that is not yet written, a loss below 1 s."""
ABANDON_TIMEOUT = 2.0
"""Longest wait for the end of a file that failed [s]."""


class Syncer:
    """Of one .rrd file in `folder`. `describe` and `end` are for the thread that writes the file."""

    def __init__(self, folder: Path, path: Path) -> None:
        """Put the file on the disk as it is; raises OSError where that fails. `start` does the rest."""
        self._folder = folder
        self._file = open_regular(path)
        try:
            os.fsync(self._file.fileno())
        except OSError:
            self.close()
            raise
        self._description: Recording | None = None
        self._problem = ""
        self._began: float | None = None
        self._thread = SupervisedThread("recording-sync", self._run)

    def start(self) -> None:
        """Go on by itself until `end`."""
        self._thread.start()

    def close(self) -> None:
        """Let go of a file with which it does not start."""
        self._file.close()

    @property
    def waiting(self) -> float:
        """For how long the disk has not answered [s]."""
        began = self._began
        return 0.0 if began is None else time.monotonic() - began

    def describe(self, recording: Recording) -> None:
        """Write this beside the data, once they are on the disk; RecordingError where the disk has failed."""
        self._description = recording
        self._require_disk()

    def end(self, timeout: float = DISK_TIMEOUT_S) -> None:
        """Put all that was written on the disk, a last time; RecordingError where that fails."""
        self._description = None  # what is said at the end is written by the one who ends it
        if not self._thread.started:
            self._sync()
        if not self._thread.stop(timeout):
            raise RecordingError(f"the disk did not take the recording within {timeout:g} s")
        self._file.close()
        self._require_disk()

    def _require_disk(self) -> None:
        if self._problem:
            raise RecordingError(f"the recording cannot be put on the disk: {self._problem}")

    def _run(self) -> None:
        while not self._thread.wait(SYNC_S) and not self._problem:
            self._sync()
        self._sync()

    def _sync(self) -> None:
        """Data first: what is said about them is true after a power cut, too."""
        said, self._description = self._description, None
        self._began = time.monotonic()
        try:
            os.fdatasync(self._file.fileno())
            if said:
                sidecar.write(self._folder, said)
        except (OSError, RecordingError) as error:  # once is enough: the system may have dropped the data for good
            self._problem = self._problem or str(error)
        finally:
            self._began = None
