"""Drawn references: planned, foreseen on the twin, kept by name."""

import asyncio

from fastapi import APIRouter, Response

from controller.reference import lettering
from server import answers
from server.deps import Holder, Parts
from server.drawings.messages import (
    DrawingBody,
    DrawingInfo,
    DrawingName,
    DrawingPlan,
    Preview,
    PreviewBody,
    TextBody,
    TextPath,
)
from server.drawings.plan import csv_of, drawing_plan
from server.drawings.preview import predicted, standing
from server.references import points

router = APIRouter(tags=["drawings"])


@router.post("/api/drawings/plan")
async def plan_drawing(body: DrawingBody, parts: Parts) -> DrawingPlan:
    """What would be followed; 422 with field, value and bound for what cannot be planned."""
    return await asyncio.to_thread(drawing_plan, body, parts.require_info().parameters, parts.operator.settings)


@router.post("/api/drawings/text")
async def text_path(body: TextBody) -> TextPath:
    """Text in single-stroke letters; 422 for a character that has none."""
    strokes = lettering.strokes(body.text, body.height)
    return TextPath(strokes=[points(one) for one in strokes], points=points(lettering.joined(strokes)))


@router.post("/api/preview")
async def preview(body: PreviewBody, parts: Parts) -> Preview:
    """The run that would follow now, on the twin of the connected rig, far faster than real time."""
    rig, settings = parts.require_info().parameters, parts.operator.settings
    async with parts.preview_lock:
        return await asyncio.to_thread(predicted, body, rig, settings, standing(parts.rig.newest))


@router.get("/api/drawings")
async def read_drawings(parts: Parts) -> list[DrawingInfo]:
    """Every saved drawing, the last saved first."""
    return await asyncio.to_thread(parts.drawings.listed)


@router.get("/api/drawings/{name}.csv", response_class=Response, responses=answers.body("text/csv", "The file"))
async def drawing_file(name: DrawingName, parts: Parts) -> Response:
    """What would be followed as CSV: t, x, y in s and m, every tick; 404 when there is none of this name."""
    rig, settings = parts.require_info().parameters, parts.operator.settings
    text = await asyncio.to_thread(csv_of, parts.drawings.read(name), rig, settings)
    return Response(text, media_type="text/csv", headers={"content-disposition": f'attachment; filename="{name}.csv"'})


@router.get("/api/drawings/{name}")
async def read_drawing(name: DrawingName, parts: Parts) -> DrawingBody:
    """A saved drawing; 404 when there is none of this name."""
    return await asyncio.to_thread(parts.drawings.read, name)


@router.put("/api/drawings/{name}")
async def save_drawing(name: DrawingName, body: DrawingBody, parts: Parts, who: Holder) -> DrawingInfo:
    """Save it under this name, in place of one that is there; operator only."""
    info = await asyncio.to_thread(parts.drawings.save, body.model_copy(update={"name": name}))
    parts.events.add(f"{who.name}: drawing {name} saved")
    return info


@router.delete("/api/drawings/{name}", status_code=204)
async def delete_drawing(name: DrawingName, parts: Parts, who: Holder) -> None:
    """Delete it; operator only, 404 when there is none of this name."""
    await asyncio.to_thread(parts.drawings.delete, name)
    parts.events.add(f"{who.name}: drawing {name} deleted")
