"""The references that the page offers."""

import asyncio

from fastapi import APIRouter

from server import references
from server.deps import Parts
from server.messages import Name, ReferenceInfo, ReferencePath

router = APIRouter(tags=["references"])


@router.get("/api/references")
async def read_references(parts: Parts) -> list[ReferenceInfo]:
    """The references for the connected rig's actuator; 503 before the first contact."""
    return await asyncio.to_thread(references.listed, parts.require_info().parameters)


@router.get("/api/references/{name}")
async def read_reference(name: Name, parts: Parts) -> ReferencePath:
    """The points of one of them; 404 with the known names."""
    return await asyncio.to_thread(references.path, parts.require_info().parameters, name)
