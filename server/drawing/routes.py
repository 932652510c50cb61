"""References: those of the library, and drawn ones: planned, and kept by name."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Body, Query, Response

from controller.reference import lettering
from server.access.permit import Holder
from server.drawing import planning
from server.drawing.imported import imported, proposed
from server.drawing.messages import (
    DrawingBody,
    DrawingInfo,
    DrawingName,
    DrawingPlan,
    ImportChoices,
    ImportedPath,
    ImportProposal,
    Name,
    ReferenceInfo,
    ReferencePath,
    TextBody,
    TextPath,
)
from server.drawing.picture import points
from server.drawing.store import GivenDrawings
from server.http import answers
from server.log.events import GivenEvents
from server.operate.operator import GivenOperator
from server.rig.client import GivenRig
from server.rig.planner import GivenPlanner

router = APIRouter()

Table = Annotated[bytes, Body(media_type="text/csv")]
Choices = Annotated[ImportChoices, Query()]


@router.post("/api/drawings/plan", tags=["drawings"])
async def plan_drawing(body: DrawingBody, rig: GivenRig, operator: GivenOperator, planner: GivenPlanner) -> DrawingPlan:
    """What would be followed; 422 with field, value and bound for what cannot be planned."""
    return await planner.do(planning.drawing_plan, body, rig.require_info().parameters, operator.settings)


@router.post("/api/drawings/text", tags=["drawings"])
async def text_path(body: TextBody) -> TextPath:
    """Text in single-stroke letters; 422 for a character that has none."""
    strokes = lettering.in_turn(lettering.strokes(body.text, body.height))
    return TextPath(strokes=[points(one) for one in strokes], points=points(lettering.joined(strokes)))


@router.post("/api/drawings/import", tags=["drawings"])
async def import_path(choices: Choices, text: Table = b"") -> ImportedPath:
    """A CSV file with columns x, y or t, x, y as a path, of which nothing is kept; 422 with line, column and value."""
    return await asyncio.to_thread(imported, text, choices)


@router.post("/api/drawings/import/proposal", tags=["drawings"])
async def propose_path(choices: Choices, text: Table = b"") -> ImportProposal:
    """How a CSV file would be imported: its columns, first rows, path or what is wrong; 422 where it is no table."""
    return await asyncio.to_thread(proposed, text, choices)


@router.get("/api/drawings", tags=["drawings"])
async def read_drawings(drawings: GivenDrawings) -> list[DrawingInfo]:
    """Every saved drawing, the last saved first."""
    return await asyncio.to_thread(drawings.listed)


@router.get(
    "/api/drawings/{name}.csv",
    tags=["drawings"],
    response_class=Response,
    responses=answers.body("text/csv", "The file"),
)
async def drawing_file(
    name: DrawingName, drawings: GivenDrawings, rig: GivenRig, operator: GivenOperator, planner: GivenPlanner
) -> Response:
    """What would be followed as CSV: t, x, y in s and m, every tick; 404 when there is none of this name."""
    drawing, parameters = await asyncio.to_thread(drawings.read, name), rig.require_info().parameters
    text = await planner.do(planning.drawing_csv, drawing, parameters, operator.settings)
    return Response(text, media_type="text/csv", headers={"content-disposition": f'attachment; filename="{name}.csv"'})


@router.get("/api/drawings/{name}", tags=["drawings"])
async def read_drawing(name: DrawingName, drawings: GivenDrawings) -> DrawingBody:
    """A saved drawing; 404 when there is none of this name."""
    return await asyncio.to_thread(drawings.read, name)


@router.put("/api/drawings/{name}", tags=["drawings"])
async def save_drawing(
    name: DrawingName, body: DrawingBody, drawings: GivenDrawings, who: Holder, events: GivenEvents
) -> DrawingInfo:
    """Save it under this name, in place of one that is there; operator only."""
    info = await asyncio.to_thread(drawings.save, body.model_copy(update={"name": name}))
    events.add(f"{who.name}: drawing {name} saved")
    return info


@router.delete("/api/drawings/{name}", tags=["drawings"], status_code=204)
async def delete_drawing(name: DrawingName, drawings: GivenDrawings, who: Holder, events: GivenEvents) -> None:
    """Delete it; operator only, 404 when there is none of this name."""
    await asyncio.to_thread(drawings.delete, name)
    events.add(f"{who.name}: drawing {name} deleted")


@router.get("/api/references", tags=["references"])
async def read_references(rig: GivenRig, planner: GivenPlanner) -> list[ReferenceInfo]:
    """The references for the connected rig's actuator; 503 before the first contact."""
    return await planner.do(planning.menu, rig.require_info().parameters)


@router.get("/api/references/{name}", tags=["references"])
async def read_reference(name: Name, rig: GivenRig, planner: GivenPlanner) -> ReferencePath:
    """The points of one of them; 404 with the known names."""
    return await planner.do(planning.reference_path, rig.require_info().parameters, name)
