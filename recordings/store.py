"""The recordings on disk: list, find, and mend what a killed writer left behind."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from controller.errors import RecordingError
from recordings import frames, sidecar, tool
from recordings.messages import Recording
from recordings.reader import read_times

TOOL_TIMEOUT = 1800.0
COMPACT_BYTES_MAX = 1 << 30
"""Larger files stay in small chunks: rerun's optimiser holds twice the file in memory."""


def default_folder() -> Path:
    """`recordings/data` of a source tree; installed as a wheel, the user's data folder."""
    here = Path(__file__).parent
    if (here.parent / "pyproject.toml").exists():
        return here / "data"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share", "tendril", "recordings")


class Store:
    """All recordings in `folder`."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder

    @property
    def folder(self) -> Path:
        """Where they are."""
        return self._folder

    def list(self) -> list[Recording]:
        """Every recording, newest first, read from the sidecars alone; damaged ones are left out."""
        found = [recording for path in self._folder.glob("*.json") if (recording := self._listed(path.stem))]
        return sorted(found, key=lambda recording: (recording.started, recording.id), reverse=True)

    def find(self, id: str) -> Recording:
        """The recording `id`; raises `RecordingError` when there is none."""
        return sidecar.read(self._folder, id)

    def path(self, id: str) -> Path:
        """The .rrd file of `id`; raises `RecordingError` when there is none or `id` is no id."""
        path = sidecar.rrd_path(self._folder, id)
        if not path.is_file():
            raise RecordingError(f"there is no recording {id!r}")
        return path

    def broken(self) -> tuple[str, ...]:
        """Ids of recordings that no writer holds any more and that were never closed."""
        return tuple(recording.id for recording in self.list() if self._is_broken(recording))

    def repair(self, id: str) -> Recording:
        """Give a killed writer's file its proper end and count what it holds; slow, runs rerun's own tools.

        Raises `RecordingError` while it is being written, or when rerun cannot mend it (the file stays as it was).
        """
        with self._held(id) as found:
            return found if found.complete or found.recovered else self._replaced(found, _mend)

    def compact(self, id: str) -> Recording:
        """Join a closed recording's many small chunks into few large ones, so that it opens quickly in the viewer.

        Slow, runs rerun's own tools; same errors as `repair`. Files above 1 GiB stay as they are.
        """
        with self._held(id) as found:
            closed = found.complete or found.recovered
            small = self.path(id).stat().st_size <= COMPACT_BYTES_MAX
            return self._replaced(found, _compact) if closed and small else found

    def _listed(self, id: str) -> Recording | None:
        try:
            return self.find(id)
        except RecordingError:
            return None

    def _is_broken(self, recording: Recording) -> bool:
        if recording.complete or recording.recovered:
            return False
        try:
            held = sidecar.lock(self.path(recording.id))
        except RecordingError:
            return False
        if held:
            held.close()
        return held is not None

    @contextmanager
    def _held(self, id: str) -> Iterator[Recording]:
        """The recording while its file is locked by us."""
        held = sidecar.lock(self.path(id))
        if held is None:
            raise RecordingError(f"recording {id!r} is still being written")
        with held:
            yield self.find(id)

    def _replaced(self, recording: Recording, make: Callable[[Path, Path], None]) -> Recording:
        """Put a better file in the place of the data once it is verified, and count what it holds."""
        path = self.path(recording.id)
        with tempfile.TemporaryDirectory(prefix=".draft-", dir=self._folder) as scratch:
            draft = Path(scratch, path.name)
            make(path, draft)
            tool.run("rrd", "verify", str(draft), timeout=TOOL_TIMEOUT)
            counted = _count(draft) | {"bytes": draft.stat().st_size}
            draft.replace(path)
        done = recording.model_copy(update={**counted, "recovered": not recording.complete})
        sidecar.write(self._folder, done)
        return done


def _mend(path: Path, draft: Path) -> None:
    """A copy of the whole frames with a footer: rerun's migration streams, so it needs little memory for any size."""
    frames.copy_whole(path, draft)
    tool.run("rrd", "migrate", str(draft), timeout=TOOL_TIMEOUT)


def _compact(path: Path, draft: Path) -> None:
    tool.run("rrd", "optimize", str(path), "-o", str(draft), timeout=TOOL_TIMEOUT)


def _count(path: Path) -> dict[str, float]:
    tick, t_ns = read_times(path)
    steps = tick[1:] - tick[:-1]
    seconds = float(t_ns[-1] - t_ns[0]) * 1e-9 if len(t_ns) else 0.0
    return {"rows": len(tick), "gaps": int((steps[steps > 1] - 1).sum()), "seconds": seconds}
