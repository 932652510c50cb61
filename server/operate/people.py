"""Who is here, and how the lease passes from one to another: the motion is held first, and everyone is told."""

import asyncio
from collections.abc import Callable, Iterable
from typing import Annotated

from controller.errors import CommandRefused, TendrilError
from controller.schema.modes import Request
from server.access.lease import OperatorLease
from server.access.permit import Permit, Permits
from server.http.given import given
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.messages import People, Person
from server.operate.operator import Operator

CHANGED = "who operates has changed meanwhile: look again"


class PeopleHere:
    """The sessions whose pages are open; `present` tells them, several times where one has several tabs."""

    def __init__(
        self,
        present: Callable[[], Iterable[Identity]],
        lease: OperatorLease,
        operator: Operator,
        permits: Permits,
        events: EventLog,
    ) -> None:
        self._present, self._lease, self._operator = present, lease, operator
        self._permits, self._events = permits, events
        self.missed = ""
        """Whose sign of presence the rig missed when it last held for lack of one, and why; "" before."""

    def view(self, who: Identity) -> People:
        """Everyone as `who` sees them."""
        holder, asking = self._lease.holder, {one.tag for one in self._lease.asking}
        return People(
            holder=holder.tag if holder else "",
            asking=[_person(one) for one in self._lease.asking],
            others=[_person(one) for one in self._here() if not one.is_session(who)],
            waiting=who.tag in asking,
        )

    def key(self) -> object:
        """Differs whenever pages should be told."""
        holder = self._lease.holder
        asking, here = ([one.tag for one in some] for some in (self._lease.asking, self._here()))
        return holder and holder.tag, asking, here, self.missed

    def note_missed(self) -> str:
        """The rig held as no sign of the operator reached it: whose, and the nearest that was silent."""
        holder = self._lease.holder
        name, timeout, age = holder.name if holder else "the operator", self._permits.timeout, self._permits.sign_age()
        if holder is not None and not self.is_here(holder):
            self.missed = f"the page of {name} is closed"
        elif age < timeout:
            self.missed = f"signs of {name} came, none reached the rig for {timeout:g} s: server or link too slow"
        else:
            self.missed = f"no sign of {name}'s open page for {timeout:g} s: browser or network too slow"
        return self.missed

    def is_here(self, who: Identity) -> bool:
        """Whether a page of this session is open."""
        return who.id in {one.id for one in self._present()}

    def ask(self, who: Identity) -> None:
        """Ask the operator for the lease."""
        self._lease.ask(who)
        self._events.done(who.name, "asks for control")

    def refuse(self, tag: str, who: Identity) -> None:
        """The holder does not give it to the session `tag`; CommandRefused when that asks no more."""
        asker = self._lease.drop_request(tag)
        if asker is None:
            raise CommandRefused("this request is no longer there")
        self._events.add(f"{who.name} keeps control: {asker.name} was refused")

    async def hand_over(self, tag: str, who: Identity) -> None:
        """Give the lease to the session `tag`, whatever its token; CommandRefused when its page is not open."""
        permit = self._permits.operator(who)
        self._require_here(tag)
        await self._hold(permit)
        permit.require()  # control may have passed, and the other page closed, while the rig came to hold
        to = self._require_here(tag)
        self._lease.give(to, f"control was handed over to {to.name}")
        self._events.add(f"{who.name} handed control over to {to.name}", "warning")

    async def take_over(self, tag: str, who: Identity) -> None:
        """Take the lease from the session `tag`, as confirmed; CommandRefused when another holds it by now."""
        holder = self._lease.holder
        if holder is None or holder.tag != tag or holder.is_session(who):
            raise CommandRefused(CHANGED)
        permit = self._permits.taking(who, holder)
        await self._hold(permit)
        if not permit.stands():
            raise CommandRefused(CHANGED)
        self._lease.give(who, f"{who.name} took control over")
        self._events.add(f"{who.name} took control from {holder.name}", "warning")

    async def _hold(self, permit: Permit) -> None:
        """Hold the motion. A rig that cannot (it is vented, or does not answer) moves nothing that could be held."""
        try:
            await asyncio.wrap_future(self._operator.request(Request.HOLD, permit))
        except TendrilError:
            return

    def _require_here(self, tag: str) -> Identity:
        to = next((one for one in self._here() if one.tag == tag), None)
        if to is None:
            raise CommandRefused("no one of this name has the page open")
        return to

    def _here(self) -> list[Identity]:
        """One entry a session, by name."""
        return sorted({one.tag: one for one in self._present()}.values(), key=lambda one: one.name)


def _person(who: Identity) -> Person:
    return Person(tag=who.tag, name=who.name, role=who.role)


GivenPeople = Annotated[PeopleHere, given(PeopleHere)]
