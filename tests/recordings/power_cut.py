"""What a power cut may leave of a folder: of recorded system calls, all that was synced and some of the rest.

Data of a file and names in a folder are there for good once each was synced; what was not may be lost or there, and
pages of a file may be there in any choice, zeros in the place of the others. Names come in their order, as file systems
with a journal keep them; a rename is whole.
"""

import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tests.recordings.system_calls import Call

Loss = Literal["all", "nothing", "data", "names", "torn"]
LOSSES: tuple[Loss, ...] = ("all", "nothing", "data", "names", "torn")
PAGE = 4096


@dataclass
class File:
    """`kept` is on the disk; `pending` are offset and data, or offset None and a length."""

    kept: bytes = b""
    pending: list[tuple[int, bytes] | int] = field(default_factory=list)

    def now(self) -> bytes:
        """With all that is pending."""
        data = bytearray(self.kept)
        for change in self.pending:
            if isinstance(change, int):
                data[change:] = bytes(max(0, change - len(data)))
            else:
                at, more = change
                data.extend(bytes(max(0, at - len(data))))
                data[at : at + len(more)] = more
        return bytes(data)

    def torn(self, chance: random.Random) -> bytes:
        """As long as with all that is pending, any pages of it in their new state."""
        old, new = self.kept, bytearray(self.now())
        for at in range(0, len(new), PAGE):
            before = old[at : at + PAGE].ljust(len(new[at : at + PAGE]), b"\0")
            if new[at : at + PAGE] != before and chance.random() < 0.5:
                new[at : at + PAGE] = before
        return bytes(new)

    def sync(self) -> None:
        self.kept, self.pending = self.now(), []


Names = dict[str, File | None]
"""By path; None is a folder."""


class Disk:
    """A folder through a program's calls. `initial` was there and on the disk before."""

    def __init__(self, initial: dict[str, bytes]) -> None:
        self._names: Names = {path: File(data) for path, data in initial.items()}
        self._kept: Names = dict(self._names)
        self._pending: list[tuple[set[str], Names, set[str]]] = []
        """Of each change of names: the folders concerned, paths that came and paths that went."""

    def apply(self, call: Call) -> None:
        """One more call."""
        file = self._names.get(call.path)
        match call.name:
            case "sync":
                self._sync(call.path)
            case "write" if file:
                file.pending.append((call.offset, call.data))
            case "truncate" if file:
                file.pending.append(call.offset)
            case "create":
                self._change({call.path: File()}, set())
            case "mkdir" if call.path != "." and call.path not in self._names:
                self._change({call.path: None}, set())
            case "remove" if call.path in self._names:
                self._change({}, {call.path})
            case "rename" if call.path in self._names:
                assert file is not None, "a folder is renamed: this model does not know what that does"
                self._change({call.to: file}, {call.path})
            case "link" if call.path in self._names and call.to not in self._names:
                self._change({call.to: file}, set())

    def left(self, loss: Loss, chance: random.Random) -> dict[str, bytes]:
        """Files by path after a cut now: what was not synced is lost, or is there, as `loss` says."""
        names = dict(self._kept)
        some = {"all": 0, "names": 0, "torn": chance.randint(0, len(self._pending))}.get(loss, len(self._pending))
        for _, come, gone in self._pending[:some]:
            _put(names, come, gone)
        return {path: self._data(file, loss, chance) for path, file in names.items() if file}

    @staticmethod
    def _data(file: File, loss: Loss, chance: random.Random) -> bytes:
        if loss == "torn":
            return file.torn(chance)
        return file.kept if loss in ("all", "data") else file.now()

    def _change(self, come: Names, gone: set[str]) -> None:
        _put(self._names, come, gone)
        self._pending.append(({str(Path(path).parent) for path in (*come, *gone)}, come, gone))

    def _sync(self, path: str) -> None:
        if (file := self._names.get(path)) is not None:
            file.sync()
            return
        for change in [change for change in self._pending if path in change[0]]:
            _put(self._kept, *change[1:])
            self._pending.remove(change)


def _put(names: Names, come: Names, gone: set[str]) -> None:
    for path in gone:
        names.pop(path, None)
    names.update(come)


def cuts(initial: dict[str, bytes], calls: list[Call]) -> Iterator[tuple[int, dict[Loss, dict[str, bytes]]]]:
    """After each call that changes something: its place, and what each kind of cut leaves."""
    disk, chance = Disk(initial), random.Random(7)
    for place, call in enumerate(calls):
        disk.apply(call)
        yield place, {loss: disk.left(loss, chance) for loss in LOSSES}
