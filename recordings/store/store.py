"""The recordings on disk: list, find, edit, check, measure, and mend what a killed writer left behind."""

import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from controller.arrays import Values
from controller.errors import CommandRefused, RecordingError
from controller.system.whole_file import PRIVATE, is_regular, sync_file, sync_folder
from recordings.format import frames, sidecar, tool
from recordings.format.messages import Recording
from recordings.read import prepared
from recordings.read.metrics import FIELDS, Measured, cycles_of, metrics_of
from recordings.read.reader import read_about, read_bookmarks, read_rows, read_times
from recordings.store.bin import Bin
from recordings.store.catalogue import Catalogue
from recordings.store.edits import Edit

COMPACT_BYTES_MAX = 1 << 30
"""Larger files stay in small chunks: rerun's optimiser holds twice the file in memory."""
DRAFT = ".draft-"
MEASURED_BYTES_MAX = 1 << 28
"""Larger files have no metrics: all their rows at once would take some GB of memory."""
MEND_MAX_S = 1800.0
"""For one run of a tool [s]."""


def default_folder() -> Path:
    """`recordings/data` of a source tree; installed as a wheel, the user's data folder."""
    here = Path(__file__).parents[1]
    if (here.parent / "pyproject.toml").exists():
        return here / "data"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share", "tendril", "recordings")


class Store:
    """All recordings in `folder`."""

    def __init__(self, folder: Path, keep_index: bool = True) -> None:
        """Nothing is asked of the folder yet: it may be missing, or take long to answer.

        `keep_index` False: the list writes nothing, not even what would make the next one quicker.
        """
        self._folder = folder
        self._catalogue = Catalogue(folder, keep_index)
        self.bin = Bin(folder)

    @property
    def folder(self) -> Path:
        """Where they are."""
        return self._folder

    def list(self) -> list[Recording]:
        """Every recording, newest first, without opening any data; a damaged one says so as its `problem`."""
        return sorted(self._catalogue.list(), key=_when, reverse=True)

    @property
    def problem(self) -> str:
        """Why the last `list` could not look into the folder, "" when it could."""
        return self._catalogue.problem

    def find(self, id: str) -> Recording:
        """The recording `id`; raises `RecordingError` when there is none."""
        return sidecar.read(self._folder, id)

    def path(self, id: str) -> Path:
        """The .rrd file of `id`; raises `RecordingError` when there is none or `id` is no id."""
        path = sidecar.rrd_path(self._folder, id)
        if not is_regular(path):
            raise RecordingError(f"there is no recording {id!r}")
        return path

    def broken(self) -> tuple[str, ...]:
        """Ids of recordings that no writer holds any more and that were never closed."""
        return tuple(found.id for found in self.list() if not _closed(found) and self._is_left(found.id))

    def repair(self, id: str) -> Recording:
        """Give a killed writer's file its proper end and count what it holds; slow, runs rerun's own tools.

        A description that is missing or damaged is made again from the data. Raises `RecordingError` while it is being
        written, or when rerun cannot mend it (the file stays as it was).
        """
        with self._held(id):
            found = self._described(id)
            return found if _closed(found) else self._replaced(found, _mend)

    def compact(self, id: str) -> Recording:
        """Join a closed recording's many small chunks into few large ones, so that it opens quickly in the viewer.

        Slow, runs rerun's own tools; same errors as `repair`. Files above 1 GiB stay as they are.
        """
        with self._held(id):
            found = self.find(id)
            small = self.path(id).stat().st_size <= COMPACT_BYTES_MAX
            return self._replaced(found, _compact) if _closed(found) and small else found

    def edit(self, id: str, edit: Edit) -> Recording:
        """Change what people say about `id`; raises `RecordingError` when there is no such recording."""
        with _refused(f"recording {id!r} cannot be changed"):
            return sidecar.update(self._folder, id, **edit.changes())

    def revise(self, id: str, change: Callable[[Recording], Recording]) -> Recording:
        """Have `change` make another description of `id`; its errors, and those of `edit`."""
        with _refused(f"recording {id!r} cannot be changed"):
            return sidecar.revise(self._folder, id, change)

    def remove(self, id: str) -> None:
        """Delete `id` into the bin; raises `CommandRefused` for one that is starred or still being written."""
        self._gone(id, self.bin.put)

    def erase(self, id: str) -> None:
        """Delete `id` for good, with the same errors."""
        self._gone(id, self._unlink)

    def restore(self, id: str) -> Recording:
        """Take `id` out of the bin; `RecordingError` where it is not there, `CommandRefused` where it cannot be."""
        with _refused(f"recording {id!r} cannot be taken back"), sidecar.turn(self._folder):
            self.bin.take_back(id)
        return next(found for found in self._catalogue.list() if found.id == id)

    def empty_bin(self, ids: Iterable[str]) -> None:
        """Remove those of the deleted recordings for good."""
        with _refused("deleted recordings cannot be removed"), sidecar.turn(self._folder):
            for id in ids:
                self.bin.erase(id)

    def clear_bin(self) -> tuple[str, ...]:
        """Remove for good what was deleted more than 7 days ago, by the time that the machine ran; their ids."""
        if not self.bin.ids():
            return ()
        with _refused("deleted recordings cannot be removed"), sidecar.turn(self._folder):
            expired = self.bin.expired()
            for id in expired:
                self.bin.erase(id)
        return expired

    def _gone(self, id: str, away: Callable[[str], None]) -> None:
        """Have `away` take the files of `id`, if they may go."""
        data, described = sidecar.rrd_path(self._folder, id), self._folder / f"{id}.json"
        if not is_regular(data) and not is_regular(described):
            raise RecordingError(f"there is no recording {id!r}")
        with _refused(f"recording {id!r} cannot be removed"), sidecar.turn(self._folder):
            if is_regular(described) and self._starred(id):
                raise CommandRefused(f"recording {id!r} is starred: take its star away first")
            if is_regular(data) and not sidecar.is_free(data):
                raise CommandRefused(f"recording {id!r} is still being written")
            away(id)

    def _unlink(self, id: str) -> None:
        data = sidecar.rrd_path(self._folder, id)
        prepared.forget(data)
        for file in filter(is_regular, (data, self._folder / f"{id}.json")):
            file.unlink(missing_ok=True)
        sync_folder(self._folder)

    def check(self, id: str) -> Recording:
        """Let rerun verify the data of `id`, and note what is wrong with it as its `problem`, "" for nothing.

        Slow; raises `RecordingError` for what is being written, or has no data or no description.
        """
        with self._held(id):
            try:
                tool.run("rrd", "verify", str(self.path(id)), timeout=MEND_MAX_S)
            except RecordingError as error:
                return sidecar.update(self._folder, id, problem=str(error))
            return sidecar.update(self._folder, id, problem="")

    def measure(self, id: str) -> Recording:
        """Take the metrics of a recording and keep them; same errors as `measured`."""
        with self._held(id):
            return sidecar.update(self._folder, id, metrics=metrics_of(self._rows(id)))

    def measured(self, id: str) -> Measured:
        """Its metrics, whole and by cycle, measured again; `RecordingError` if there is none, or a too large one."""
        rows = self._rows(id)
        return Measured(whole=metrics_of(rows), cycles=tuple(cycles_of(rows)))

    def sweep(self) -> None:
        """Remove the drafts of data that killed processes left behind, and end what they began to delete."""
        with suppress(OSError), sidecar.turn(self._folder):
            self.bin.settle()
        for left in self._folder.glob(f"{DRAFT}*"):
            id = left.name.removeprefix(DRAFT)
            if sidecar.is_id(id) and sidecar.is_free(sidecar.rrd_path(self._folder, id)):
                shutil.rmtree(left, ignore_errors=True)

    @contextmanager
    def _draft(self, id: str) -> Iterator[Path]:
        """Where better data for `id`, which is held, may be written."""
        scratch = self._folder / f"{DRAFT}{id}"
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir(sidecar.FOLDER_MODE)
        try:
            yield scratch / f"{id}.rrd"
        finally:
            shutil.rmtree(scratch, ignore_errors=True)

    def _rows(self, id: str) -> dict[str, Values]:
        path = self.path(id)
        if path.stat().st_size > MEASURED_BYTES_MAX:
            raise RecordingError(f"recording {id!r} is larger than {MEASURED_BYTES_MAX >> 20} MiB: it is not measured")
        return read_rows(path, FIELDS)

    def _is_left(self, id: str) -> bool:
        data = sidecar.rrd_path(self._folder, id)
        return is_regular(data) and sidecar.is_free(data)

    def _starred(self, id: str) -> bool:
        try:
            return self.find(id).starred
        except RecordingError:  # damaged: no one can say so any more
            return False

    @contextmanager
    def _held(self, id: str) -> Iterator[None]:
        """No one else writes the data of `id` meanwhile."""
        held = sidecar.lock(self.path(id))
        if held is None:
            raise RecordingError(f"recording {id!r} is still being written")
        with held:
            yield

    def _described(self, id: str) -> Recording:
        """The recording `id`, its description made from its data where it cannot be read."""
        try:
            return self.find(id)
        except RecordingError:
            sidecar.write(self._folder, _from_data(id, self.path(id)))
            return self.find(id)

    def _replaced(self, recording: Recording, make: Callable[[Path, Path], None]) -> Recording:
        """Put a better file in the place of the data once it is verified and on the disk, and count what it holds.

        A power cut leaves the old data or the new, and nothing is said of the new before they are there for good.
        """
        path = self.path(recording.id)
        with self._draft(recording.id) as draft:
            make(path, draft)
            tool.run("rrd", "verify", str(draft), timeout=MEND_MAX_S)
            counted = _count(draft) | {"bytes": draft.stat().st_size}
            draft.chmod(PRIVATE)
            sync_file(draft)
            draft.replace(path)
            sync_folder(self._folder)
        return sidecar.update(self._folder, recording.id, **counted, recovered=not recording.complete, problem="")


@contextmanager
def _refused(what: str) -> Iterator[None]:
    """A folder that takes no change is a refusal with its reason, as of one that is read-only or gone."""
    try:
        yield
    except OSError as error:
        raise CommandRefused(f"{what}: {error.strerror}") from error


def _when(recording: Recording) -> tuple[str, datetime, str]:
    """By its id first, which begins with the second: times take ten times as long to compare."""
    return recording.id[:15], recording.started, recording.id


def _closed(recording: Recording) -> bool:
    return recording.complete or recording.recovered


def _mend(path: Path, draft: Path) -> None:
    """A copy of the whole frames with a footer: rerun's migration streams, so it needs little memory for any size."""
    frames.copy_whole(path, draft, frames.intact_length(path))
    tool.run("rrd", "migrate", str(draft), timeout=MEND_MAX_S)


def _compact(path: Path, draft: Path) -> None:
    """A copy in few large chunks."""
    tool.run("rrd", "optimize", str(path), "-o", str(draft), timeout=MEND_MAX_S)


def _count(path: Path) -> dict[str, float]:
    """Rows, missing ticks and seconds that the data come to."""
    tick, t_ns = read_times(path)
    steps = tick[1:] - tick[:-1]
    seconds = float(t_ns[-1] - t_ns[0]) * 1e-9 if len(t_ns) else 0.0
    return {"rows": len(tick), "gaps": int((steps[steps > 1] - 1).sum()), "seconds": seconds}


def _from_data(id: str, path: Path) -> Recording:
    """What the data say of themselves; they still have to be counted."""
    info, settings = read_about(path)
    known = {"bytes": path.stat().st_size, "twin": info.twin, "rig": info.rig, "settings": settings}
    known["bookmarks"] = read_bookmarks(path)
    return sidecar.blank(id, actuator=info.parameters.actuator.name).model_copy(update=known)
