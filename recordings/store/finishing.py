"""What is done with a recording once it has ended, in a process that reads: it keeps a core busy for a while."""

from pathlib import Path

from controller.errors import TendrilError
from recordings.format import sidecar
from recordings.read.metrics import Measured
from recordings.read.quick import prepare
from recordings.read.reader import read_about, read_times
from recordings.read.thumbnail import thumbnail
from recordings.store.store import Store


def finish(folder: Path, id: str) -> tuple[str, ...]:
    """Compact it, measure it, prepare its quick look and picture; what of that could not be done, and why."""
    store, problems = Store(folder), []
    for work in (store.compact, store.measure, lambda id: _depict(store, id)):
        try:
            work(id)
        except (TendrilError, OSError) as error:
            problems.append(str(error))
    return tuple(problems)


def depict(folder: Path, id: str) -> None:
    """Make the picture of an older recording: an empty one where its data cannot be read, or they would be again."""
    store = Store(folder)
    try:
        _depict(store, id)
    except (TendrilError, OSError):
        sidecar.update(folder, id, thumbnail="")


def _depict(store: Store, id: str) -> None:
    sidecar.update(store.folder, id, thumbnail=thumbnail(prepare(store.path(id))))


def measured(folder: Path, id: str) -> Measured:
    """`Store.measured`."""
    return Store(folder).measured(id)


def repair(folder: Path, id: str) -> None:
    """`Store.repair`."""
    Store(folder).repair(id)


def check(folder: Path, id: str) -> None:
    """`Store.check`."""
    Store(folder).check(id)


def end_of(path: Path) -> tuple[int, int | None]:
    """The rig's boot that was recorded, and the last tick in the file, None without rows."""
    ticks, _ = read_times(path)
    return read_about(path)[0].boot, int(ticks[-1]) if len(ticks) else None
