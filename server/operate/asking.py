"""What a run of several requests needs of each of them: the row that came of its own, and words for anybody else's."""

import asyncio

import numpy as np

from controller.errors import RigUnreachable
from controller.schema.modes import Request
from server.access.permit import Permit
from server.rig.client import Rig

POLL = 5e-3
"""Between two looks at the telemetry [s]."""


async def shown(rig: Rig, n: int, patience: float) -> np.void:
    """The first row that came of command number `n`; RigUnreachable where none does within `patience` [s]."""
    loop = asyncio.get_running_loop()
    end = loop.time() + patience
    while (newest := rig.newest) is None or newest[0]["command_n"] < n:
        if loop.time() > end:
            raise RigUnreachable("the rig does not answer")
        await asyncio.sleep(POLL)
    row: np.void = newest[0]
    return row


def asked_for(request: Request, permit: Permit | None) -> str:
    """What was asked of the rig, and by whom where that is known."""
    what = request.name.replace("_", "-") if request != Request.NONE else "another target"
    return what if permit is None else f"{what}, asked for by {permit.name}"
