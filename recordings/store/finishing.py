"""What is done with a recording once it has ended, in a process of its own: it keeps a core busy for a while."""

from pathlib import Path

from controller.errors import TendrilError
from recordings.read.metrics import Measured
from recordings.read.quick import prepare
from recordings.store.store import Store


def finish(folder: Path, id: str) -> tuple[str, ...]:
    """Compact it, measure it and prepare its quick look; what of that could not be done, and why."""
    store, problems = Store(folder), []
    for work in (store.compact, store.measure, lambda id: prepare(store.path(id))):
        try:
            work(id)
        except (TendrilError, OSError) as error:
            problems.append(str(error))
    return tuple(problems)


def measured(folder: Path, id: str) -> Measured:
    """`Store.measured`."""
    return Store(folder).measured(id)
