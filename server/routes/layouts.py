"""Layouts of plots, kept for the browser that asks."""

import asyncio

from fastapi import APIRouter, HTTPException

from server.deps import Me, Parts
from server.plots.messages import LayoutName, PlotLayout

router = APIRouter(tags=["plots"])


@router.get("/api/layouts")
async def read_layouts(parts: Parts, who: Me) -> list[str]:
    """Names of my layouts."""
    return await asyncio.to_thread(parts.layouts.names, who)


@router.get("/api/layouts/{name}")
async def read_layout(name: LayoutName, parts: Parts, who: Me) -> PlotLayout:
    """One of my layouts; 404 when I have none of this name."""
    found = await asyncio.to_thread(parts.layouts.read, who, name)
    if found is None:
        raise HTTPException(404, f"you have no layout named {name}")
    return found


@router.put("/api/layouts/{name}")
async def keep_layout(name: LayoutName, body: PlotLayout, parts: Parts, who: Me) -> PlotLayout:
    """Keep a layout for me; 409 when I have too many."""
    await asyncio.to_thread(parts.layouts.write, who, name, body)
    return body


@router.delete("/api/layouts/{name}", status_code=204)
async def delete_layout(name: LayoutName, parts: Parts, who: Me) -> None:
    """Forget one of my layouts."""
    await asyncio.to_thread(parts.layouts.delete, who, name)
