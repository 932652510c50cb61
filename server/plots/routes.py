"""The visible window of the plots as a file, and layouts of plots, kept for the browser that asks."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Query
from starlette.responses import StreamingResponse

from server.http import answers
from server.http.errors import NotFound
from server.http.who import Me
from server.plots.layouts import GivenLayouts
from server.plots.messages import CHANNELS_MAX, LayoutName, PlotLayout
from server.plots.table import Window, lines, table
from server.rig.client import GivenRig
from server.rig.history import GivenHistory
from server.rig.messages import ChannelKey

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
