"""The recordings on disk: list, find, and mend what a killed writer left behind."""

import os
from pathlib import Path

from controller.errors import RecordingError
from recordings import sidecar, tool
from recordings.messages import Recording
from recordings.reader import read_times

REPAIR_TIMEOUT = 600.0


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
        found, path = self.find(id), self.path(id)
        held = sidecar.lock(path)
        if held is None:
            raise RecordingError(f"recording {id!r} is still being written")
        with held:
            if not found.complete and not found.recovered:
                found = self._mend(found, path)
        return found

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

    def _mend(self, recording: Recording, path: Path) -> Recording:
        draft = path.with_suffix(".mending")
        try:
            tool.run("rrd", "route", str(path), "-o", str(draft), timeout=REPAIR_TIMEOUT)
            tool.run("rrd", "verify", str(draft), timeout=REPAIR_TIMEOUT)
            tick, t_ns = read_times(draft)
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)
        steps = tick[1:] - tick[:-1]
        seconds = float(t_ns[-1] - t_ns[0]) * 1e-9 if len(t_ns) else 0.0
        counted = {"rows": len(tick), "gaps": int((steps[steps > 1] - 1).sum()), "seconds": seconds}
        mended = recording.model_copy(update={**counted, "bytes": path.stat().st_size, "recovered": True})
        sidecar.write(self._folder, mended)
        return mended
