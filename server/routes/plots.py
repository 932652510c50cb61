"""The visible window of the plots as a file."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query
from starlette.responses import StreamingResponse

from server import answers
from server.deps import Parts
from server.plots.messages import CHANNELS_MAX, ChannelKey
from server.plots.table import NothingKept, Window, lines, table

router = APIRouter(tags=["plots"])

Keys = Annotated[list[ChannelKey], Query(min_length=1, max_length=CHANNELS_MAX)]


@router.get("/api/history.csv", response_class=StreamingResponse, responses=answers.body("text/csv", "The file"))
async def history_csv(
    start: Annotated[float, Query(alias="from", allow_inf_nan=False)],
    stop: Annotated[float, Query(alias="to", allow_inf_nan=False)],
    channels: Keys,
    parts: Parts,
) -> StreamingResponse:
    """The channels from `from` to `to` [s, rig clock], SI: every tick of the last minute, else 16 ms extremes."""
    info = parts.require_info()
    try:
        found = await asyncio.to_thread(table, parts.history, Window(start, stop, channels))
    except NothingKept as error:
        raise HTTPException(404, str(error)) from error
    headers = {"content-disposition": f'attachment; filename="tendril-{info.rig}.csv"', "cache-control": "no-store"}
    text = lines(found, info.rig, info.wall_offset_ns * 1e-9)
    return StreamingResponse(text, headers=headers, media_type="text/csv; charset=utf-8")
