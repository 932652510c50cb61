"""The operator's lease."""

from fastapi import APIRouter

from controller.errors import CommandRefused
from server.deps import Me, Parts
from server.messages import Lease

router = APIRouter(tags=["lease"])


@router.post("/api/lease")
async def take_lease(parts: Parts, who: Me) -> Lease:
    """Become the operator; 409 while another is."""
    if not parts.lease.acquire(who):
        raise CommandRefused(f"{parts.lease.view(who).holder} operates now")
    return parts.lease.view(who)


@router.delete("/api/lease")
async def release_lease(parts: Parts, who: Me) -> Lease:
    """Stop being the operator; a motion is held."""
    parts.lease.release(who)
    return parts.lease.view(who)
