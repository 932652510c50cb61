"""One recording from its first to its last row: the file, its sidecar, its counters and its lock."""

import shutil
import time
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from controller.arrays import Rows
from controller.errors import RecordingError
from controller.schema.messages import RigInfo
from controller.schema.parameters import Settings
from recordings.format import sidecar
from recordings.format.about import About
from recordings.format.annotations import Annotation, LogLine, Mark
from recordings.format.messages import (
    BOOKMARKS_MAX,
    Bookmark,
    Hole,
    Profile,
    Recording,
    RecordingState,
    Restart,
)
from recordings.write.syncing import ABANDON_TIMEOUT, Syncer

REPORT_SECONDS = 1.0
DISK_FREE_MIN = 256 << 20
"""Room [B] that a recording leaves on the disk: it ends before the disk is full."""
HOLES_MAX = 100
"""Holes that are listed, and restarts; all missing ticks are counted."""


@dataclass(frozen=True)
class Context:
    """What a recording is told beside name, rig and settings."""

    profile: Profile = "full"
    operator: str = ""
    reference: str = ""
    part_of: str = ""
    """Id of the recording that this one goes on."""
    earlier: Rows | None = None
    """Rows that come before those in memory; None takes the last 10 s."""
    after: int | None = None
    """The last tick of the part before it: what lies between is a hole."""


class Session:
    """A recording that is being written. Not thread-safe."""

    def __init__(self, folder: Path, name: str, info: RigInfo, settings: Settings, context: Context) -> None:
        """Create the files; raises `RecordingError` when that fails or the disk has no room."""
        from recordings.write.rrd import RrdFile  # late: a server knows these words, and has no rerun

        check_room(folder)
        self._folder = folder
        self._info, self._settings, self._context = info, settings, context
        self._started = datetime.now(UTC)
        self._name = name.strip() or f"{info.parameters.actuator.name} on {info.rig}"
        self.id, self._lock = sidecar.claim(folder, name, self._started)
        self._path = sidecar.rrd_path(folder, self.id)
        self._first_ns = self._last_ns = 0
        self._last_tick = context.after
        self._rows = self._gaps = 0
        self._holes: tuple[Hole, ...] = ()
        self._restarts: tuple[Restart, ...] = ()
        self.bookmarks: tuple[Bookmark, ...] = ()
        """As the sidecar has them, where people may change them meanwhile."""
        self._marked = 0
        self._reported, self._grown = time.monotonic(), (0, 0)
        """When the disk was last asked, and the rows and bytes of then."""
        with ExitStack() as undo:  # a file that could not be begun holds nothing, and no lock
            undo.callback(self._lock.close)
            undo.callback(self._path.unlink, missing_ok=True)
            self._file = RrdFile(self._path, About(self.id, self._name, info, settings, context.profile))
            undo.callback(self._file.abandon)
            self._file.flush()
            self._syncer = Syncer(folder, self._path)
            undo.callback(self._syncer.close)
            undo.callback(sidecar.path(folder, self.id).unlink, missing_ok=True)
            sidecar.write(folder, self.described())
            self._syncer.start()
            undo.pop_all()

    def write(self, rows: Rows) -> None:
        """Append rows (n,) and count them; once a second see whether the disk still takes them."""
        if not self._rows:
            self._first_ns = int(rows["t_ns"][0])
        self._file.write(rows)
        self._count(rows)
        if time.monotonic() - self._reported >= REPORT_SECONDS:
            self._report()

    def annotate(self, annotation: Annotation) -> None:
        """Note it at the newest row."""
        self._file.annotate(annotation)

    def mark(self, label: str) -> Bookmark:
        """A bookmark at the newest row, which is still to be written into the sidecar; RecordingError before a row."""
        if not self._rows or self._last_tick is None:
            raise RecordingError("nothing is recorded yet that could be marked")
        if self._marked >= BOOKMARKS_MAX:
            raise RecordingError(f"this recording has had {self._marked} bookmarks, which is the most")
        self._marked += 1
        mark = Bookmark(n=self._marked, tick=self._last_tick, t=self._seconds, label=label)
        self.annotate(Mark(mark.n, label))
        return mark

    def end(self) -> Recording:
        """Close the file and mark it complete."""
        self._file.flush()
        return self._release(complete=True)

    def next(self) -> "Session":
        """The recording's next part, after this one has ended."""
        part_of = self._context.part_of or self.id
        context = replace(self._context, part_of=part_of, earlier=None, after=self._last_tick)
        return Session(self._folder, self._name, self._info, self._settings, context)

    def abandon(self, reason: str) -> Recording:
        """Close what can be closed after `reason`: the file stays readable as far as it goes."""
        with suppress(RecordingError):  # then it says so in its description alone
            self.annotate(LogLine(reason, "error"))
        return self._release(complete=False)

    def state(self) -> RecordingState:
        """The recorder's state while this session runs."""
        return RecordingState(
            recording=True,
            id=self.id,
            seconds=self._seconds,
            rows=self._rows,
            gaps=self._gaps,
            origin=self._first_ns * 1e-9,
            bookmarks=self.bookmarks,
        )

    @property
    def waiting(self) -> float:
        """For how long the disk has not put on it what was written [s]."""
        return self._syncer.waiting

    @property
    def bytes(self) -> int:
        """Size of the file so far."""
        return self._path.stat().st_size

    def described(self, complete: bool = False) -> Recording:
        """The row of the list, as things stand."""
        context = self._context
        return Recording(
            id=self.id,
            name=self._name,
            started=self._started,
            seconds=self._seconds,
            rows=self._rows,
            gaps=self._gaps,
            bytes=self.bytes,
            actuator=self._info.parameters.actuator.name,
            twin=self._info.twin,
            complete=complete,
            rig=self._info.rig,
            operator=context.operator,
            reference=context.reference,
            profile=context.profile,
            settings=self._settings,
            holes=self._holes,
            restarts=self._restarts,
            part_of=context.part_of,
        )

    @property
    def _seconds(self) -> float:
        return max(0, self._last_ns - self._first_ns) * 1e-9

    def _count(self, rows: Rows) -> None:
        """Count rows and missing ticks; both a gap and a restart of the rig are written into the log."""
        ticks = rows["tick"] if self._last_tick is None else np.concatenate(([self._last_tick], rows["tick"]))
        t_ns = np.concatenate(([self._last_ns or rows["t_ns"][0]], rows["t_ns"]))[-len(ticks) :]
        steps = np.diff(ticks)
        missing = int((steps[steps > 1] - 1).sum())
        if missing:
            holes = [Hole(after=int(ticks[i]), ticks=int(steps[i]) - 1) for i in np.flatnonzero(steps > 1)]
            self._holes = (*self._holes, *holes)[:HOLES_MAX]
            self.annotate(LogLine(f"{missing} ticks before tick {ticks[-1]} were not delivered", "warning"))
        for i in np.flatnonzero(steps <= 0):
            self._count_restart(int(ticks[i]), max(0, int(t_ns[i + 1] - t_ns[i])) * 1e-9)
        self._gaps += missing
        self._rows += len(rows)
        self._last_tick, self._last_ns = int(rows["tick"][-1]), int(rows["t_ns"][-1])

    def _count_restart(self, after: int, seconds: float) -> None:
        self._restarts = (*self._restarts, Restart(after=after, seconds=seconds))[:HOLES_MAX]
        text = f"the rig was restarted: its ticks begin again, {seconds:.3f} s after tick {after}"
        self.annotate(LogLine(text, "warning"))

    def _report(self) -> None:
        self._reported = time.monotonic()
        self._file.flush()
        self._require_growth()
        check_room(self._folder)
        self._syncer.describe(self.described())

    def _require_growth(self) -> None:
        """What was handed over is in the file: rerun does not always say that its writer failed."""
        (rows, size), self._grown = self._grown, (self._rows, self.bytes)
        if self._rows > rows and self._grown[1] <= size:
            raise RecordingError(f"the recording's file grows no more (disk full?): {size} bytes since row {rows}")

    def _release(self, complete: bool) -> Recording:
        """The order is what counts: the data are on the disk before anything says that they are complete."""
        try:
            (self._file.close if complete else self._file.abandon)()
            if complete:
                self._syncer.end()
            else:
                with suppress(RecordingError):  # the first error is the one that counts
                    self._syncer.end(ABANDON_TIMEOUT)
            return sidecar.write(self._folder, self.described(complete))
        finally:
            self._lock.close()


def check_room(folder: Path) -> None:
    """Raise `RecordingError` when the disk is nearly full."""
    free = shutil.disk_usage(folder).free
    if free < DISK_FREE_MIN:
        least = f"a recording leaves at least {DISK_FREE_MIN >> 20} MiB"
        full = f"the disk is nearly full: {free >> 20} MiB are free, {least}, in {folder}"
        raise RecordingError(f"{full}; deleted ones take room there until they are removed for good")
