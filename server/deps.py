"""What routes ask for, as annotated types."""

from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from controller.errors import NotAllowed
from server.auth import Identity
from server.permit import Permit
from server.services import Services


async def _parts(connection: HTTPConnection) -> Services:
    services: Services = connection.app.state.services
    return services


Parts = Annotated[Services, Depends(_parts)]
"""Everything the server is made of."""


async def _me(connection: HTTPConnection) -> Identity:
    who: Identity | None = connection.state.who
    if who is None:
        raise NotAllowed("sign in first")
    return who


Me = Annotated[Identity, Depends(_me)]
"""The signed-in session that asks; the gate has checked it."""


async def _holder(who: Me, parts: Parts) -> Identity:
    parts.lease.require(who)
    parts.lease.touch(who)
    return who


Holder = Annotated[Identity, Depends(_holder)]
"""The session that asks, which must hold the operator's lease."""


async def _permitted(who: Holder, parts: Parts) -> Permit:
    return parts.permits.operator(who)


Permitted = Annotated[Permit, Depends(_permitted)]
"""The leave of the session that asks, which must hold the lease now, and again where its request leaves for the rig."""
