"""How the rig's devices fare, and its rig file."""

import asyncio

from fastapi import APIRouter

from controller.schema.hardware import Drivers
from server.access.asking import Permitted
from server.hardware.messages import RigFileState, RigFileText
from server.hardware.rig_file import GivenRigFile
from server.rig.client import GivenRig

router = APIRouter(tags=["hardware"])


@router.get("/api/drivers")
async def read_drivers(rig: GivenRig) -> Drivers:
    """How each of the rig's drivers fares, now, with its newest raw values; none of a twin. 503 without the rig."""
    rig.require_info()
    return await asyncio.to_thread(rig.drivers)


@router.get("/api/rig-file")
async def read_rig_file(keeper: GivenRigFile) -> RigFileState:
    """The rig file, and whether the rig runs with what it says."""
    return await asyncio.to_thread(keeper.state)


@router.put("/api/rig-file", status_code=202)
async def write_rig_file(body: RigFileText, keeper: GivenRigFile, permit: Permitted) -> None:
    """Check, write and restart the rig; 409 unless it is VENTED, ours, and nothing is recorded.

    422 names field, value and bound. A rig that does not tick with it goes back to what ticked last, and the log says
    why; the file then holds what was written.
    """
    await keeper.write(body.text, permit)
