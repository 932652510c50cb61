"""What follows from changes that were not asked for: a line in the log, a HOLD for what a lost operator left."""

from controller.schema.messages import Latched
from controller.schema.modes import Cause, Mode
from controller.schema.states import LIVE
from controller.system.event_bus import EventBus
from recordings.format.messages import Level
from server.log.events import EventLog, words
from server.operate.events import BootChanged, LeaseChanged, ModeChanged, ObserverReseated, TroubleChanged
from server.operate.operator import Operator
from server.operate.people import PeopleHere
from server.operate.settings import too_strong
from server.rig.client import Rig


class Reactions:
    """Only the event loop uses it."""

    def __init__(self, rig: Rig, operator: Operator, people: PeopleHere, events: EventLog, bus: EventBus) -> None:
        self._rig, self._operator, self._people, self._events = rig, operator, people, events
        bus.subscribe(BootChanged, "what is said of the rig", self._on_boot)
        bus.subscribe(TroubleChanged, "what is said of the link", self._on_trouble)
        bus.subscribe(LeaseChanged, "the hold of what was left", self._on_lease)
        bus.subscribe(ModeChanged, "what is said of the mode", self._on_mode)
        bus.subscribe(ObserverReseated, "what is said of the observer", self._on_reseat)

    def _on_boot(self, event: BootChanged) -> None:
        if event.boot is None:
            return self._events.add("the rig is gone", "error")
        again, latched = event.met not in (None, event.boot), self._rig.info and self._rig.info.latched
        if latched:
            self._on_latched(latched, "restarted" if again else "is connected")
        elif again:
            self._events.add("the rig restarted: arm it again", "warning")
            self._operator.stopper.over()
        else:
            self._events.add("the rig is connected")
        if self._rig.info is not None:  # such settings came from another actuator
            for text in too_strong(self._operator.settings, self._rig.info).values():
                self._events.add(f"the rig takes less: {text}", "warning")

    def _on_latched(self, latched: Latched, what: str) -> None:
        """It was stopped before this boot of it, or before this server."""
        if latched.mode == Mode.E_STOP:
            self._operator.stopper.over(latched.by)
        by = f"by {latched.by}" if latched.by else words(latched.cause)
        since = latched.at.astimezone().strftime("%Y-%m-%d %H:%M:%S")
        self._events.add(f"the rig {what}, still in {words(latched.mode)} ({by}) since {since}: clear it", "error")

    def _on_trouble(self, event: TroubleChanged) -> None:
        if event.trouble:
            self._events.add(f"the rig takes no command from this server: {event.trouble}", "error")
        else:
            self._events.add("the rig takes commands from this server again; its settings are those of this page")

    def _on_lease(self, event: LeaseChanged) -> None:
        if event.before is not None:
            closed = "" if self._people.is_here(event.before) else "; its page is closed"
            self._events.add(f"{event.before.name} no longer operates: {event.why}{closed}")
            # The next operator's page must not keep a motion going that someone else began; in HOLD, too: the last
            # operator's FOLLOW may be under way while the newest row still says HOLD.
            newest = self._rig.newest
            if self._rig.paused or (newest is not None and newest[0]["mode"] in LIVE):
                self._operator.hold_left()
        if event.holder is not None:
            self._events.add(f"{event.holder.name} operates")

    def _on_mode(self, event: ModeChanged) -> None:
        if event.before is None:
            return
        why = self._why(event.mode, event.cause)
        self._events.add(f"rig: {words(event.mode)} ({why})", _level(event.mode, event.cause))
        if event.before == Mode.E_STOP != event.mode:
            self._operator.stopper.over()

    def _on_reseat(self, event: ObserverReseated) -> None:
        self._events.add("the observer was wound: it begins again from the pose that fits the markers", "warning")

    def _why(self, mode: Mode, cause: Cause) -> str:
        """The cause in words; of an E-STOP that was pressed here, by whom, and of a sign that was missed, whose."""
        if cause == Cause.OPERATOR_LOST:
            return self._people.note_missed()
        pressed = mode == Mode.E_STOP and cause == Cause.OPERATOR
        by = self._operator.stopper.by if pressed else ""
        return f"by {by}" if by else words(cause)


def _level(mode: Mode, cause: Cause) -> Level:
    if mode in (Mode.FAULT, Mode.E_STOP):
        return "error"
    expected = (Cause.NONE, Cause.OPERATOR, Cause.START, Cause.RESTED, Cause.REFERENCE_DONE)
    return "info" if cause in expected else "warning"
