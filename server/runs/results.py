"""What came of the last runs, kept over a restart of the server."""

from pathlib import Path

from pydantic import TypeAdapter

from controller.whole_file import write_whole
from server.runs.messages import RunResult

KEPT = 100
_LIST: TypeAdapter[list[RunResult]] = TypeAdapter(list[RunResult])


class Results:
    """The last results, newest first, in one file."""

    def __init__(self, path: Path) -> None:
        """Read what an earlier server kept; nothing when there is none, or none that this version understands."""
        self._path = path
        try:
            self._kept = _LIST.validate_json(path.read_bytes())
        except (OSError, ValueError):  # ValidationError is a ValueError
            self._kept = []

    @property
    def newest(self) -> RunResult | None:
        """The last run's; None before the first."""
        return self._kept[0] if self._kept else None

    def next_id(self) -> int:
        """A number that no kept result has."""
        return 1 + max((result.id for result in self._kept), default=0)

    def all(self) -> list[RunResult]:
        """Newest first."""
        return list(self._kept)

    def add(self, result: RunResult) -> None:
        """Keep one more; raises OSError where it will not outlive this server."""
        self._kept = [result, *self._kept[: KEPT - 1]]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, _LIST.dump_json(self._kept), lasting=False)  # the event loop must not wait for a disk
