"""The hand on the target: press, move, release and leave, once, for every door by which a page moves it."""

from concurrent.futures import Future
from typing import Annotated, Literal

from controller.schema.messages import CommandReply
from controller.schema.modes import Mode, Request
from server.access.lease import OperatorLease
from server.access.permit import Permits
from server.http.given import given
from server.http.who import Identity
from server.log.audit import tell
from server.log.events import EventLog
from server.operate.operator import Operator, Target
from server.rig.history import History

_MOVED = (Mode.HOLD, Mode.FOLLOW)
"""HOLD too: the newest row may be older than the press."""


class TargetContext:
    """What every hand needs, and which one pressed last."""

    def __init__(
        self, lease: OperatorLease, permits: Permits, operator: Operator, history: History, events: EventLog
    ) -> None:
        self.lease, self.permits, self.operator = lease, permits, operator
        self.history, self.events = history, events
        self.last: TargetControl | None = None

    @property
    def moved(self) -> bool:
        """Whether the rig may follow the target that a hand moved last."""
        newest = self.history.newest
        return newest is not None and newest[0]["mode"] in _MOVED


GivenTargetContext = Annotated[TargetContext, given(TargetContext)]


class TargetControl:
    """One page's, on the `target` of the plan or on the `gizmo` of the 3D view."""

    def __init__(self, who: Identity, context: TargetContext, grips: Literal["target", "gizmo"] = "target") -> None:
        self._who, self._context, self._grips = who, context, grips

    def press(self, at: Target) -> "Future[CommandReply]":
        """A fresh press at a point [m], the only thing that may leave HOLD; NotAllowed unless `who` operates."""
        permit = self._context.permits.signed(self._who)
        self._context.last = self
        tell(f"follow, {self._grips} at ({at[0]:.4f}, {at[1]:.4f}) m")
        return self._context.operator.request(Request.FOLLOW, permit, at)

    def move(self, at: Target) -> "Future[CommandReply]":
        """The target is at another point [m]; NotAllowed unless `who` operates."""
        return self._context.operator.request(Request.NONE, self._context.permits.signed(self._who), at)

    def ask(self, request: Request) -> "Future[CommandReply]":
        """Ask for another mode; NotAllowed unless `who` operates."""
        return self._context.operator.request(request, self._context.permits.signed(self._who))

    def release(self, always: bool = False) -> None:
        """The hand let go: with the held clutch, or `always`, the rig holds, if it is the operator's."""
        if (always or self._context.lease.clutch) and self._context.lease.holds(self._who):
            self._hold()
            tell("the plan moved under the drag: hold" if always else f"{self._grips} let go: hold")

    def leave(self, followed: bool) -> None:
        """Its page is gone. Where another tab of the session is still present (`followed`), no one there began this
        motion: hold it. Where none is, no one signs any more, and the rig holds by itself.
        """
        if self._context.last is not self:
            return
        self._context.last = None
        if followed and self._context.moved and self._context.lease.holds(self._who):
            self._hold()
            self._context.events.add(f"{self._who.name}: the tab that moved the {self._grips} was closed: hold")

    def sign(self) -> None:
        """A sign of the operator at this page; NotAllowed unless `who` operates."""
        self._context.operator.present(self._context.permits.signed(self._who))

    def _hold(self) -> None:
        self._context.operator.request(Request.HOLD, self._context.permits.operator(self._who))
