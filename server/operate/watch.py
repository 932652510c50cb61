"""What nobody asked for but everyone should know: the rig came or went, restarted, changed mode; the lease lapsed."""

from controller.schema.modes import Cause, Mode
from controller.schema.states import LIVE
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.log.events import EventLog, Level, words
from server.operate.operator import Operator
from server.operate.settings import too_strong
from server.rig.client import Rig
from server.rig.history import History


class Watch:
    """Compares with the beat before."""

    watched = "rig, lease and mode"

    def __init__(self, rig: Rig, history: History, lease: OperatorLease, operator: Operator, events: EventLog) -> None:
        self._rig, self._history, self._lease, self._operator, self._events = rig, history, lease, operator, events
        self._connected: int | None = None
        self._boot: int | None = None
        self._holder: Identity | None = None
        self._term = lease.term
        self._mode: tuple[Mode, Cause] | None = None
        self._reseats: int | None = None
        self._trouble = ""

    def look(self) -> None:
        """Look once."""
        self._look_at_rig()
        self._look_at_trouble()
        self._look_at_lease()
        self._look_at_mode()
        self._look_at_observer()

    def _look_at_rig(self) -> None:
        boot = self._rig.boot()
        if boot == self._connected:
            return
        if boot is None:
            self._events.add("the rig is gone", "error")
        elif self._boot not in (None, boot):
            self._events.add("the rig restarted: arm it again", "warning")
            self._operator.stopper.over()
        else:
            self._events.add("the rig is connected")
        self._connected, self._boot = boot, boot or self._boot
        if boot is not None and self._rig.info is not None:  # such settings came from another actuator
            for text in too_strong(self._operator.settings, self._rig.info).values():
                self._events.add(f"the rig takes less: {text}", "warning")

    def _look_at_trouble(self) -> None:
        trouble, before = self._rig.trouble, self._trouble
        if trouble == before:
            return
        self._trouble = trouble
        if trouble:
            self._events.add(f"the rig takes no command from this server: {trouble}", "error")
        else:
            self._events.add("the rig takes commands from this server again; its settings are those of this page")

    def _look_at_lease(self) -> None:
        term, holder, before = self._lease.term, self._lease.holder, self._holder
        if term == self._term:
            return
        self._term, self._holder = term, holder
        if before is not None:
            self._events.add(f"{before.name} no longer operates")
            # The next operator's page must not keep a motion going that someone else began; in HOLD, too: the last
            # operator's FOLLOW may be under way while the newest row still says HOLD.
            if self._rig.paused or (self._mode is not None and self._mode[0] in LIVE):
                self._operator.hold_left()
        if holder is not None:
            self._events.add(f"{holder.name} operates")

    def _look_at_mode(self) -> None:
        newest = self._history.newest
        if newest is None:
            self._mode = None
            return
        mode, cause = Mode(int(newest[0]["mode"])), Cause(int(newest[0]["cause"]))
        if self._mode not in (None, (mode, cause)):
            self._events.add(f"rig: {words(mode)} ({self._why(mode, cause)})", _level(mode, cause))
        if mode != Mode.E_STOP and self._mode is not None and self._mode[0] == Mode.E_STOP:
            self._operator.stopper.over()
        self._mode = mode, cause

    def _look_at_observer(self) -> None:
        newest, before = self._history.newest, self._reseats
        self._reseats = None if newest is None else int(newest[0]["reseats"])
        if before is not None and self._reseats is not None and self._reseats > before:
            self._events.add("the observer was wound: it begins anew from the pose that fits the markers", "warning")

    def _why(self, mode: Mode, cause: Cause) -> str:
        """The cause in words; of an E-STOP that was pressed here, by whom."""
        pressed = mode == Mode.E_STOP and cause == Cause.OPERATOR
        by = self._operator.stopper.by if pressed else ""
        return f"by {by}" if by else words(cause)


def _level(mode: Mode, cause: Cause) -> Level:
    if mode in (Mode.FAULT, Mode.E_STOP):
        return "error"
    expected = (Cause.NONE, Cause.OPERATOR, Cause.START, Cause.RESTED, Cause.REFERENCE_DONE)
    return "info" if cause in expected else "warning"
