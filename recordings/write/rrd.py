"""One .rrd file while it is written: telemetry rows in, rerun columns out. Not thread-safe: one thread owns it."""

import tempfile
from concurrent.futures import Future, wait
from contextlib import suppress
from pathlib import Path

import numpy as np
import rerun as rr

from controller.arrays import Array, Mask, Rows
from controller.errors import RecordingError
from controller.schema.layout import record_dtype
from controller.schema.messages import RigInfo, Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters, Settings
from controller.system.memory import give_back
from controller.system.thread import in_thread
from controller.system.whole_file import sync_file
from recordings.format import plan
from recordings.format.about import About, description, word
from recordings.format.annotations import Annotation, Approach, LogLine, Mark
from recordings.format.blueprint import APPLICATION, layout, style
from recordings.format.messages import Level
from recordings.format.profiles import TICKS, rounded
from recordings.format.signals import APPROACH, BOOKMARKS, GROUPS, MARKERS, MODE_COLORS, Group, rgba
from recordings.format.tool import release_streams
from recordings.write.syncing import ABANDON_TIMEOUT

FLUSH_S = 2.0
"""Between two looks at whether rerun's writer is still there, while it is waited for [s]."""
TIMED_OUT = "timed out"
"""rerun's word for a flush that goes on."""
THREADS, WRITER = Path("/proc/self/task"), "file_writer"
"""Where Linux shows the threads of this process, and rerun's name of one that writes a file."""
BATCH = 1000
"""Rows in one batch of columns, where all are known already."""
_ENDING: list[Future[None]] = []
"""Ends of files that rerun has not reached: of one whose writer is gone it may wait for ever."""
MODE_LEVELS: dict[int, Level] = {Mode.FAULT: "warning", Mode.E_STOP: "error"}


class RrdFile:
    """Writes rows to one file; every call returns as soon as rerun has taken the data."""

    def __init__(self, path: Path, about: About) -> None:
        """Create `path`; raises `RecordingError` when that fails."""
        self._path, self._about = path, about
        self._origin: int | None = None
        self._last: Rows | None = None
        rr.set_strict_mode(True)
        self._stream = rr.RecordingStream(
            APPLICATION, recording_id=about.id, batcher_config=rr.ChunkBatcherConfig(flush_tick=0.03)
        )
        others = _writers()
        try:
            self._stream.save(path)
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{path} cannot be written: {error}") from error
        self._writers = _writers() - others
        length = about.info.parameters.actuator.length
        self._stream.log_file_from_contents(Path("layout.rbl"), layout(length))
        self._write_static()

    def write(self, rows: Rows) -> None:
        """Append `rows` (n,) of Telemetry, in the order of their ticks, n >= 1."""
        if self._origin is None:
            self._begin(int(rows["t_ns"][0]))
        rows = rounded(rows) if self._about.profile == "standard" else rows
        on_grid = rows[plan.on_grid(rows["tick"])]
        self._write_groups(rows, on_grid)
        self._write_markers(rows)
        if len(on_grid):
            plan.write(self._stream, self._times, on_grid)
        self._write_modes(rows)
        self._last = rows[-1:].copy()

    def annotate(self, annotation: Annotation) -> None:
        """Note it at the newest row; before the first row there is a place for lines of the log only."""
        at = self._last if self._last is not None else np.zeros(1, [(n, "<i8") for n in ("tick", "t_ns")])
        match annotation:
            case LogLine(text, level):
                self._log(at, text, level)
            case _ if self._last is None:
                return
            case Approach(first, end):
                self._stream.send_columns(APPROACH, self._times(at), rr.Scalars.columns(scalars=[[first, end]]))
            case Mark(n, label):
                line = rr.TextLog.columns(text=[f"{n} {label}".rstrip()], level=["INFO"])
                self._stream.send_columns(BOOKMARKS, self._times(at), line)

    def flush(self) -> None:
        """Hand everything to the operating system, however long it takes; `RecordingError` when it takes no more.

        rerun waits for ever for a writer that dies just as it is asked.
        """
        while True:
            try:
                return self._stream.flush(timeout_sec=FLUSH_S)
            except RuntimeError as error:
                if TIMED_OUT not in str(error) or self._writer_ended():
                    text = f"the recording cannot be written any further (disk full?): {error}"
                    raise RecordingError(text) from error

    def close(self) -> None:
        """Write the footer and close the file; then no other call may follow. `RecordingError` when it took no footer.

        rerun does not always say that its writer failed, and keeps 1 MB of the file until it is told so.
        """
        size = self._path.stat().st_size
        self._disconnect()
        if self._path.stat().st_size <= size:
            raise RecordingError(f"the recording's file grew no more at its end (disk full?): {size} bytes")
        del self._stream
        _ENDING[:] = [one for one in _ENDING if not one.done()]
        if not _ENDING:  # rerun would wait for them, too
            release_streams()
        give_back()

    def abandon(self) -> None:
        """Close a file that takes no more."""
        wait([self._end()], ABANDON_TIMEOUT)

    def _disconnect(self) -> None:
        """However long it takes, but not for ever where the writer has ended without it."""
        done, ended = self._end(), False
        while not wait([done], FLUSH_S).done:
            if ended:
                raise RecordingError("the recording could not be ended (disk full?): rerun's writer is gone")
            ended = self._writer_ended()
        done.result()

    def _end(self) -> Future[None]:
        """rerun's end of it, apart from us: where its writer is gone it may wait for ever."""
        _ENDING.append(in_thread("end-of-rrd", self._stream.disconnect))
        return _ENDING[-1]

    def _writer_ended(self) -> bool:
        """Whether rerun's writer of this file is gone, where threads can be seen."""
        return bool(self._writers) and not self._writers & _writers()

    def _begin(self, t_ns: int) -> None:
        self._origin = t_ns
        wall = t_ns + self._about.info.wall_offset_ns
        self._stream.send_recording_start_time_nanos(wall)
        self._stream.send_property("clock", rr.AnyValues(t_ns_origin=np.array([t_ns], np.int64)))

    def _write_static(self) -> None:
        about, stream = self._about, self._stream
        stream.send_recording_name(about.name)
        stream.send_property(
            "tendril",
            rr.AnyValues(
                rig=about.info.rig,
                version=about.info.version,
                actuator=about.info.parameters.actuator.name,
                profile=about.profile,
                info=about.info.model_dump_json(),
                settings=about.settings.model_dump_json(),
            ),
        )
        stream.log("/about", rr.TextDocument(description(about), media_type="text/markdown"), static=True)
        for group in (*GROUPS, *((TICKS,) if about.profile == "standard" else ())):
            stream.log(group.path, style(group), static=True)
        stream.log("/mode", _mode_style(), static=True)
        plan.write_static(stream, about.info.parameters.actuator)

    def _times(self, rows: Rows) -> list[rr.TimeColumn]:
        """Timelines, exact integers: `t` since the first row, `tick`, and but in `standard` `time` in UTC.

        `time` is `t` and a constant (the recording's start is in its properties), for 60 MB an hour.
        """
        t_ns = rows["t_ns"].astype(np.int64)
        columns = [
            rr.TimeColumn("t", duration=(t_ns - (self._origin or 0)).astype("timedelta64[ns]")),
            rr.TimeColumn("tick", sequence=rows["tick"].astype(np.int64)),
        ]
        if self._about.profile == "full":
            wall = t_ns + self._about.info.wall_offset_ns
            columns.append(rr.TimeColumn("time", timestamp=wall.astype("datetime64[ns]")))
        return columns

    def _write_groups(self, rows: Rows, on_grid: Rows) -> None:
        if self._about.profile == "full":
            return self._send(GROUPS, rows)
        self._send((TICKS,), rows)
        if len(on_grid):
            self._send(GROUPS, on_grid)

    def _send(self, groups: tuple[Group, ...], rows: Rows) -> None:
        times = self._times(rows)
        for group in groups:
            self._stream.send_columns(group.path, times, rr.Scalars.columns(scalars=_matrix(rows, group)))

    def _write_markers(self, rows: Rows) -> None:
        fresh = rows[_changed(rows, self._last, "markers")]
        if len(fresh):
            times = self._times(fresh)
            values = fresh["markers"].reshape(len(fresh), -1)
            self._stream.send_columns(MARKERS, times, rr.Scalars.columns(scalars=values))
            plan.write_markers(self._stream, times, fresh)

    def _write_modes(self, rows: Rows) -> None:
        """The band of modes, and a line in the log for each change of mode."""
        for row in rows[_changed(rows, self._last, "mode")]:
            mode, cause = Mode(row["mode"]), Cause(row["cause"])
            at = row.reshape(1)
            self._stream.send_columns("/mode", self._times(at), rr.StateChange.columns(state=[word(mode)]))
            self._log(at, f"{word(mode)} ({word(cause).lower()})", MODE_LEVELS.get(mode, "info"))

    def _log(self, at: Rows, text: str, level: Level) -> None:
        """A line at the row `at` (1,), with its time in the text too: rerun's own column of times is too narrow."""
        seconds = (int(at["t_ns"][0]) - (self._origin or 0)) * 1e-9
        word = {"warning": "WARN"}.get(level, level.upper())
        line = rr.TextLog.columns(text=[f"{seconds:.2f} s  {text}"], level=[word])
        self._stream.send_columns("/log", self._times(at), line)


def write_whole(path: Path, about: About, rows: Rows) -> None:
    """All of a recording that is known already, `rows` (n,), into `path` and on the disk; errors as of `RrdFile`."""
    file = RrdFile(path, about)
    for begin in range(0, len(rows), BATCH):
        file.write(rows[begin : begin + BATCH])
    file.flush()
    file.close()
    sync_file(path)


def warm_up() -> None:
    """Let rerun do its first call (145 ms of lazy imports) on a file that is thrown away."""
    no_rig = RigInfo(
        rig="", boot=0, version="", layout="", wall_offset_ns=0, policy="", twin=True, parameters=RigParameters()
    )
    with tempfile.TemporaryDirectory(prefix="tendril-warm-up-") as folder:
        file = RrdFile(Path(folder, "warm-up.rrd"), About("warm-up", "warm-up", no_rig, Settings()))
        file.write(np.zeros(2, record_dtype(Telemetry)))
        file.close()


def _writers() -> set[str]:
    """Threads of this process that write a file of rerun's; none where they cannot be seen."""
    found = set()
    for name in THREADS.glob("*/comm"):
        with suppress(OSError):  # it has ended meanwhile
            if name.read_text().strip() == WRITER:
                found.add(name.parent.name)
    return found


def _mode_style() -> rr.StateConfiguration:
    """The band of modes: a word and a colour each."""
    words = [word(mode) for mode in Mode]
    return rr.StateConfiguration(values=words, labels=words, colors=rgba(MODE_COLORS[mode] for mode in Mode))


def _matrix(rows: Rows, group: Group) -> Array:
    """The group's series side by side: (rows, series)."""
    out = np.empty((len(rows), len(group.series)))
    for column, series in enumerate(group.series):
        values = rows[series.field]
        out[:, column] = values if series.index is None else values[:, series.index]
    return out


def _changed(rows: Rows, last: Rows | None, field: str) -> Mask:
    """Which rows differ from the row before in `field`, bit by bit (nan equals nan): (rows,) of bool."""
    now = np.ascontiguousarray(rows[field]).view(np.int64).reshape(len(rows), -1)
    change = np.ones(len(rows), np.bool_)
    change[1:] = (now[1:] != now[:-1]).any(axis=1)
    if last is not None:
        change[0] = bool((np.ascontiguousarray(last[field]).view(np.int64).reshape(-1) != now[0]).any())
    return change
