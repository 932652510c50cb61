"""The operator's lease."""

from fastapi import APIRouter

from controller.errors import CommandRefused
from server.deps import Holder, Me, Parts
from server.messages import Lease, LeaseBody, SessionTag

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


@router.post("/api/lease/request")
async def ask_for_lease(parts: Parts, who: Me) -> Lease:
    """Ask whoever operates for the lease; the request stands for a minute. 409 where nobody operates."""
    parts.company.ask(who)
    return parts.lease.view(who)


@router.delete("/api/lease/request")
async def withdraw_request(parts: Parts, who: Me) -> Lease:
    """Ask no longer."""
    parts.lease.drop_request(who.tag)
    return parts.lease.view(who)


@router.post("/api/lease/refuse")
async def refuse_request(body: SessionTag, parts: Parts, who: Holder) -> Lease:
    """Keep the lease, and tell who asked; 409 when it asks no more."""
    parts.company.refuse(body.tag, who)
    return parts.lease.view(who)


@router.post("/api/lease/hand-over")
async def hand_over_lease(body: SessionTag, parts: Parts, who: Holder) -> Lease:
    """Give the lease to another session, a viewer's too; the motion is held first. 409 when its page is not open."""
    await parts.company.hand_over(body.tag, who)
    return parts.lease.view(who)


@router.post("/api/lease/take-over")
async def take_over_lease(body: SessionTag, parts: Parts, who: Me) -> Lease:
    """Take the lease from its holder (named, so that nobody else loses it); held first. 403 with a viewer's token."""
    await parts.company.take_over(body.tag, who)
    return parts.lease.view(who)
