"""The operator's lease: at most one session operates; it lapses when nothing is heard of its page."""

import time
from collections.abc import Callable

from controller.errors import NotAllowed
from server.auth import Identity
from server.messages import Lease

LAPSE = 5.0
"""Seconds without a sign of the holder after which the lease is free again."""


class OperatorLease:
    """One holder or none. Only the event loop uses it, so there is no lock."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._holder: Identity | None = None
        self._heard = 0.0
        self.clutch = False
        """Held clutch: letting go of a target holds the rig. It stays as it is from one holder to the next."""

    @property
    def holder(self) -> Identity | None:
        """Who operates now; a lapsed lease is free."""
        if self._holder is not None and self._now() - self._heard > LAPSE:
            self._holder = None
        return self._holder

    def holds(self, who: Identity) -> bool:
        """Whether `who` operates now."""
        return self.holder is not None and self.holder.id == who.id

    def require(self, who: Identity) -> None:
        """Raise `NotAllowed` unless `who` operates."""
        if self.holds(who):
            return
        by = f"{self.holder.name} operates now" if self.holder else "nobody operates now: take the lease first"
        raise NotAllowed(f"only the operator may do this; {by}")

    def acquire(self, who: Identity) -> bool:
        """Take the lease if it is free (or mine already); False when another holds it."""
        if self.holder is not None and not self.holds(who):
            return False
        self._holder, self._heard = who, self._now()
        return True

    def release(self, who: Identity) -> bool:
        """Give the lease back; False when `who` did not hold it."""
        if not self.holds(who):
            return False
        self._holder = None
        return True

    def touch(self, who: Identity) -> None:
        """A sign of `who`'s page: it keeps the lease alive if it is theirs."""
        if self.holds(who):
            self._heard = self._now()

    def view(self, who: Identity) -> Lease:
        """The lease as `who` sees it."""
        holder = self.holder
        name = holder.name if holder else ""
        return Lease(held=holder is not None, mine=self.holds(who), holder=name, clutch=self.clutch)
