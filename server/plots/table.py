"""A window of the history as CSV: every tick where all of its rows are kept, else the extremes of 16 ticks."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import numpy.typing as npt

from server.http.errors import NotFound
from server.rig.channels import CHANNELS, columns_of
from server.rig.history import BIN_TICKS, History

LINES = 1000
"""Lines that are made at once."""
_ROWS = "every tick"
_BINS = f"lowest and highest value of {BIN_TICKS} ticks in each line, t in their middle: older ticks are not kept"


class NothingKept(NotFound):
    """The history has nothing of the window."""


@dataclass(frozen=True)
class Window:
    """What is asked for: the time [s, rig clock] and the keys of the channels."""

    start: float
    stop: float
    keys: list[str]


@dataclass(frozen=True)
class Table:
    """Numbers (n, columns) in SI, time first, with their names, and what a line is."""

    names: list[str]
    values: npt.NDArray[np.float64]
    content: str


def table(history: History, window: Window) -> Table:
    """The window as numbers; `UnknownChannel`, or `NothingKept` when no time of it is in the history."""
    places = columns_of(window.keys)
    channels = [CHANNELS[place] for place in places]
    labels = [f"{channel.key} [{channel.unit}]" for channel in channels]
    values = history.samples(window.start, window.stop, channels)
    found = _bins(history, window, places, labels) if values is None else Table(["t [s]", *labels], values, _ROWS)
    if not len(found.values):
        raise NothingKept(f"nothing is kept of {window.start:.12g} s to {window.stop:.12g} s on the rig's clock")
    return found


def lines(found: Table, rig: str, wall_offset: float) -> Iterator[str]:
    """The CSV in pieces; `wall_offset` is Unix time minus the rig's clock [s]."""
    began = datetime.fromtimestamp(found.values[0, 0] + wall_offset, UTC)
    yield f"# rig {rig}, first line at {began.isoformat(timespec='milliseconds')}; t is the rig's clock\n"
    yield f"# {found.content}\n"
    yield ",".join(found.names) + "\n"
    form = ",".join(["%.4f", *["%.9g"] * (len(found.names) - 1)]) + "\n"
    for first in range(0, len(found.values), LINES):
        yield "".join(form % tuple(line) for line in found.values[first : first + LINES].tolist())


def _bins(history: History, window: Window, places: list[int], labels: list[str]) -> Table:
    bins = history.bins(history.bin_at(window.start), history.bin_at(window.stop), places)
    both = np.stack([bins.low, bins.high], axis=2).reshape(len(bins.t), -1)
    names = [f"{label} {end}" for label in labels for end in ("low", "high")]
    return Table(["t [s]", *names], np.column_stack([bins.t, both.astype(np.float64)]), _BINS)
