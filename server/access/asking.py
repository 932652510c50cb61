"""Who asks, and whether they may: for the arguments of routes."""

from typing import Annotated

from fastapi import Depends

from server.access.lease import GivenLease
from server.access.permit import GivenPermits, Permit
from server.http.who import Identity, Me


async def holder(who: Me, lease: GivenLease) -> Identity:
    """Dependency of routes that only who operates may use; raises `NotAllowed` for others."""
    lease.require(who)
    lease.touch(who)
    return who


Holder = Annotated[Identity, Depends(holder)]
"""The session that asks, which must hold the operator's lease."""


async def _permitted(who: Holder, permits: GivenPermits) -> Permit:
    return permits.operator(who)


Permitted = Annotated[Permit, Depends(_permitted)]
"""The leave of the session that asks, which must hold the lease now, and again where its request leaves for the rig."""
