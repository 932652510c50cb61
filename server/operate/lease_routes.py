"""The operator's lease."""

from fastapi import APIRouter

from controller.errors import CommandRefused
from server.access.lease import GivenLease
from server.access.messages import Lease
from server.access.permit import Holder
from server.http.who import Me
from server.log.events import GivenEvents
from server.operate.messages import LeaseBody, SessionTag
from server.operate.people import GivenPeople

router = APIRouter(tags=["lease"])


@router.post("/api/lease")
async def take_lease(lease: GivenLease, who: Me) -> Lease:
    """Become the operator; 409 while another is."""
    if not lease.acquire(who):
        raise CommandRefused(f"{lease.view(who).holder} operates now")
    return lease.view(who)


@router.delete("/api/lease")
async def release_lease(lease: GivenLease, who: Me) -> Lease:
    """Stop being the operator; a motion is held."""
    lease.release(who)
    return lease.view(who)


@router.patch("/api/lease")
async def change_lease(body: LeaseBody, lease: GivenLease, events: GivenEvents, who: Holder) -> Lease:
    """Switch the held clutch on or off."""
    lease.clutch = body.clutch
    events.add(f"{who.name}: held clutch {'on' if body.clutch else 'off'}")
    return lease.view(who)


@router.post("/api/lease/request")
async def ask_for_lease(lease: GivenLease, people: GivenPeople, who: Me) -> Lease:
    """Ask the operator for the lease; the request stands for a minute. 409 where no one operates."""
    people.ask(who)
    return lease.view(who)


@router.delete("/api/lease/request")
async def withdraw_request(lease: GivenLease, who: Me) -> Lease:
    """Ask no longer."""
    lease.drop_request(who.tag)
    return lease.view(who)


@router.post("/api/lease/refuse")
async def refuse_request(body: SessionTag, lease: GivenLease, people: GivenPeople, who: Holder) -> Lease:
    """Keep the lease, and tell who asked; 409 when it asks no more."""
    people.refuse(body.tag, who)
    return lease.view(who)


@router.post("/api/lease/hand-over")
async def hand_over_lease(body: SessionTag, lease: GivenLease, people: GivenPeople, who: Holder) -> Lease:
    """Give the lease to another session, a viewer's too; the motion is held first. 409 when its page is not open."""
    await people.hand_over(body.tag, who)
    return lease.view(who)


@router.post("/api/lease/take-over")
async def take_over_lease(body: SessionTag, lease: GivenLease, people: GivenPeople, who: Me) -> Lease:
    """Take the lease from its holder (named, so that no one else loses it); held first. 403 with a viewer's token."""
    await people.take_over(body.tag, who)
    return lease.view(who)
