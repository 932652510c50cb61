"""The operator's lease."""

from fastapi import APIRouter

from controller.errors import CommandRefused
from server.deps import Holder, Me, Parts
from server.messages import Lease, LeaseBody

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


@router.patch("/api/lease")
async def change_lease(body: LeaseBody, parts: Parts, who: Holder) -> Lease:
    """Switch the held clutch on or off."""
    parts.lease.clutch = body.clutch
    parts.events.add(f"{who.name}: held clutch {'on' if body.clutch else 'off'}")
    return parts.lease.view(who)
