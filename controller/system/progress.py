"""How much of some work is done: told by who does it, shown at the terminal with how long the rest will take."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn

ProgressCallback = Callable[[float], None]
"""Is told the share that is done, from 0 to 1."""


def no_progress(share: float) -> None:
    """No one waits to be told."""


class Bar:
    """What `progress` shows: called with the share that is done."""

    def __init__(self, bars: "Progress", what: str) -> None:
        self._bars, self._task = bars, bars.add_task(what, total=None)

    def __call__(self, share: float) -> None:
        """The share is done; before the first one the bar only shows that something goes on."""
        self._bars.update(self._task, total=1.0, completed=share)

    def name(self, what: str) -> None:
        """What is being done now."""
        self._bars.update(self._task, description=what)


def say(console: "Console", what: str) -> None:
    """What begins, as a line on the standard error where no bar is seen: `console` is at no terminal."""
    if not console.is_terminal:
        sys.stderr.write(f"{what} ...\n")
        sys.stderr.flush()


@contextmanager
def progress(console: "Console", what: str) -> Iterator[Bar]:
    """A bar that is gone at the end; at no terminal there is one line instead, on the standard error."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn  # not for a rig, which only tells

    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(), remaining()
    say(console, what)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        yield Bar(bars, what)


def remaining() -> "ProgressColumn":
    """How long the rest will take, by what is done so far."""
    from rich.progress import TimeRemainingColumn

    return TimeRemainingColumn(elapsed_when_finished=True)
