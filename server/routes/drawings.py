"""Drawn references: planned, foreseen on the twin, kept by name."""

from fastapi import APIRouter
from starlette.responses import Response

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

router = APIRouter(tags=["drawings"])


@router.post("/api/drawings/plan")
async def plan_drawing(body: DrawingBody, parts: Parts) -> DrawingPlan:
    """What would be followed; 422 with field, value and bound for what cannot be planned."""
    raise NotImplementedError


@router.post("/api/drawings/text")
async def text_path(body: TextBody) -> TextPath:
    """Text in single-stroke letters; 422 for a character that has none."""
    raise NotImplementedError


@router.post("/api/preview")
async def preview(body: PreviewBody, parts: Parts) -> Preview:
    """Run it on the twin of the connected rig, far faster than real time."""
    raise NotImplementedError


@router.get("/api/drawings")
async def read_drawings(parts: Parts) -> list[DrawingInfo]:
    """Every saved drawing, the last saved first."""
    raise NotImplementedError


@router.get("/api/drawings/{name}.csv", response_class=Response)
async def drawing_file(name: DrawingName, parts: Parts) -> Response:
    """What would be followed as CSV: t, x, y in s and m, every tick; 404 when there is none of this name."""
    raise NotImplementedError


@router.get("/api/drawings/{name}")
async def read_drawing(name: DrawingName, parts: Parts) -> DrawingBody:
    """A saved drawing; 404 when there is none of this name."""
    raise NotImplementedError


@router.put("/api/drawings/{name}")
async def save_drawing(name: DrawingName, body: DrawingBody, parts: Parts, who: Holder) -> DrawingInfo:
    """Save it under this name, in place of one that is there; operator only."""
    raise NotImplementedError


@router.delete("/api/drawings/{name}", status_code=204)
async def delete_drawing(name: DrawingName, parts: Parts, who: Holder) -> None:
    """Delete it; operator only, 404 when there is none of this name."""
    raise NotImplementedError
