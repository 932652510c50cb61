"""What came of the last runs, kept over a restart of the server."""

import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter

from controller.system.state_file import StateFile
from server.runs.messages import RunResult

KEPT = 100
_LIST: TypeAdapter[list[RunResult]] = TypeAdapter(list[RunResult])

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RunEnded:
    """A run is over, and this is what came of it."""

    result: RunResult


class Results:
    """The last results, newest first, in one file."""

    def __init__(self, path: Path, publish: Callable[[RunEnded], None] = lambda event: None) -> None:
        """Read what an earlier server kept; nothing when there is none, or none that this version understands."""
        self._publish = publish
        self._file = StateFile(path, _LIST.validate_json, "the results of earlier runs are missing")
        self._kept = self._file.read() or []
        self._saver = ThreadPoolExecutor(1, "results")
        self._saving: Future[None] | None = None

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
        """Keep one more: on the disk a moment later, as no one here may wait for that.

        Raises OSError where the one before, or this one, will not outlive this server.
        """
        self._kept = [result, *self._kept[: KEPT - 1]]
        self._publish(RunEnded(result))
        before, self._saving = self._saving, self._saver.submit(self._save, _LIST.dump_json(self._kept))
        if before is not None and before.done() and (error := before.exception()) is not None:
            raise error

    def close(self) -> None:
        """Wait until the last one is kept."""
        self._saver.shutdown()

    def _save(self, text: bytes) -> None:
        try:
            self._file.path.parent.mkdir(parents=True, exist_ok=True)
            self._file.write(text)
        except OSError as error:
            log.warning("the results of the last runs will not outlive this server: %s", error)
            raise
