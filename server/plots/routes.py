"""The visible window of the plots as a file, and layouts of plots, kept for the browser that asks."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated

import numpy as np
import numpy.typing as npt
from fastapi import APIRouter, Query
from starlette.responses import StreamingResponse

from server.http import answers
from server.http.errors import NotFound
from server.http.who import Me
from server.plots.layouts import GivenLayouts
from server.plots.messages import CHANNELS_MAX, LayoutName, PlotLayout
from server.rig.channels import CHANNELS, columns_of
from server.rig.client import GivenRig
from server.rig.history import BIN_TICKS, GivenHistory, History
from server.rig.messages import ChannelKey

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


router = APIRouter(tags=["plots"])

Keys = Annotated[list[ChannelKey], Query(min_length=1, max_length=CHANNELS_MAX)]


@router.get("/api/history.csv", response_class=StreamingResponse, responses=answers.body("text/csv", "The file"))
async def history_csv(
    start: Annotated[float, Query(alias="from", allow_inf_nan=False)],
    stop: Annotated[float, Query(alias="to", allow_inf_nan=False)],
    channels: Keys,
    rig: GivenRig,
    history: GivenHistory,
) -> StreamingResponse:
    """The channels from `from` to `to` [s, rig clock], SI: every tick of the last minute, else 16 ms extremes."""
    info = rig.require_info()
    found = await asyncio.to_thread(table, history, Window(start, stop, channels))
    headers = {"content-disposition": f'attachment; filename="tendril-{info.rig}.csv"', "cache-control": "no-store"}
    text = lines(found, info.rig, info.wall_offset_ns * 1e-9)
    return StreamingResponse(text, headers=headers, media_type="text/csv; charset=utf-8")


@router.get("/api/layouts")
async def read_layouts(layouts: GivenLayouts, who: Me) -> list[str]:
    """Names of my layouts."""
    return await asyncio.to_thread(layouts.names, who)


@router.get("/api/layouts/{name}")
async def read_layout(name: LayoutName, layouts: GivenLayouts, who: Me) -> PlotLayout:
    """One of my layouts; 404 when I have none of this name."""
    found = await asyncio.to_thread(layouts.read, who, name)
    if found is None:
        raise NotFound(f"you have no layout named {name}")
    return found


@router.put("/api/layouts/{name}")
async def keep_layout(name: LayoutName, body: PlotLayout, layouts: GivenLayouts, who: Me) -> PlotLayout:
    """Keep a layout for me; 409 when I have too many."""
    await asyncio.to_thread(layouts.write, who, name, body)
    return body


@router.delete("/api/layouts/{name}", status_code=204)
async def delete_layout(name: LayoutName, layouts: GivenLayouts, who: Me) -> None:
    """Forget one of my layouts."""
    await asyncio.to_thread(layouts.delete, who, name)
