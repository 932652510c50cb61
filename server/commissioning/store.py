"""What each step came to, kept over a restart of the server, and the settings that a step has borrowed."""

from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from pydantic import JsonValue

from controller.schema.layout import Model
from controller.schema.parameters import Settings
from controller.system.state_file import StateFile
from server.commissioning.messages import Number, StepName


class Found(NamedTuple):
    """What a step came to."""

    good: bool
    """It may be accepted."""
    text: str
    """In one or two sentences, 200 characters at most where it is good: the rig file keeps it."""
    numbers: tuple[Number, ...] = ()
    changes: dict[str, JsonValue] = {}  # noqa: RUF012  never changed
    """What `accept` writes into the rig file."""
    data: dict[str, JsonValue] = {}  # noqa: RUF012
    """For the steps that rest on it, and for the report's figures."""
    again: bool = False
    """What it writes makes another measurement necessary: it is accepted, and is to be done once more."""


class KeptResult(Model):
    """What a step came to, by whom and when."""

    good: bool
    text: str
    numbers: list[Number] = []
    changes: dict[str, JsonValue] = {}
    before: dict[str, JsonValue] = {}
    """Values of the rig file in the place of `changes`."""
    data: dict[str, JsonValue] = {}
    again: bool = False
    by: str
    at: datetime


class Kept(Model):
    """The whole file."""

    results: dict[StepName, KeptResult] = {}
    borrowed: Settings | None = None
    """Settings to be put back: those of the operator, while a step has others in force."""


class CommissioningStore:
    """Reads and writes the file; one that cannot be used counts as nothing done, and the log says so."""

    def __init__(self, path: Path) -> None:
        self._file = StateFile(path, Kept.model_validate_json, "no step of the commissioning counts as done")
        self.kept = self._file.read() or Kept()

    def keep(self, step: StepName, result: KeptResult | None) -> None:
        """Keep the step's result, or forget it; raises OSError where the file cannot be written."""
        results = {name: one for name, one in self.kept.results.items() if name != step}
        self._write(self.kept.model_copy(update={"results": results | ({step: result} if result else {})}))

    def forget(self, steps: set[StepName]) -> None:
        """Forget what these came to; raises OSError."""
        results = {name: one for name, one in self.kept.results.items() if name not in steps}
        self._write(self.kept.model_copy(update={"results": results}))

    def borrow(self, settings: Settings | None) -> None:
        """Note which settings are to be put back, None once they are; raises OSError."""
        self._write(self.kept.model_copy(update={"borrowed": settings}))

    def _write(self, wanted: Kept) -> None:
        self._file.path.parent.mkdir(parents=True, exist_ok=True)
        self._file.write(wanted.model_dump_json())
        self.kept = wanted


def commissioning_file(state: Path, rig: str) -> Path:
    """Where a rig's results are kept, in the state folder."""
    return state / f"commissioning-{rig}.json"


def data_folder(state: Path, rig: str) -> Path:
    """Where its measured tables lie."""
    return state / f"commissioning-{rig}"
