"""The references that the page offers."""

import asyncio

from fastapi import APIRouter

from server.drawing import references
from server.drawing.messages import Name, ReferenceInfo, ReferencePath
from server.rig.client import GivenRig

router = APIRouter(tags=["references"])


@router.get("/api/references")
async def read_references(rig: GivenRig) -> list[ReferenceInfo]:
    """The references for the connected rig's actuator; 503 before the first contact."""
    return await asyncio.to_thread(references.listed, rig.require_info().parameters)


@router.get("/api/references/{name}")
async def read_reference(name: Name, rig: GivenRig) -> ReferencePath:
    """The points of one of them; 404 with the known names."""
    return await asyncio.to_thread(references.path, rig.require_info().parameters, name)
