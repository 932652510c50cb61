"""What a run of several requests needs: the row that came of each, and words for what ends it before its own end."""

import asyncio

import numpy as np

from controller.errors import CommandRefused, RigUnreachable
from controller.schema.modes import Cause, Mode, Request
from server.access.permit import Permit
from server.log.events import words
from server.operate.operator import Operator, Target
from server.rig.client import Rig

POLL = 5e-3
"""Between two looks at the telemetry [s]."""
PATIENCE = 5.0
"""Longest wait for a row that shows what was asked for [s]."""


async def ask(rig: Rig, operator: Operator, request: Request, permit: Permit, target: Target | None = None) -> np.void:
    """Ask the rig; the first row that came of it. CommandRefused where it does not do it, RigUnreachable without."""
    reply = await asyncio.wrap_future(operator.request(request, permit, target))
    if not reply.accepted:
        raise CommandRefused(reply.detail)
    return await shown(rig, reply.n, PATIENCE)


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


def why_over(rig: Rig, boot: int, permit: Permit, overtaken: str) -> str:
    """Why what was begun in this `boot` of the rig under `permit` may not go on, "" while it may.

    `overtaken`: what else was asked for meanwhile, by `asked_for`.
    """
    if not permit.stands():
        return f"{permit.name} no longer operates"
    if (now := rig.boot()) != boot or rig.newest is None:
        return "the rig is gone" if now is None or rig.newest is None else "the rig restarted"
    return overtaken


def found_in(mode: Mode, cause: Cause) -> str:
    """The rig is in another mode than it should be."""
    return f"the rig is in {words(mode)} ({words(cause)})"
