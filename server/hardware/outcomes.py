"""What another actuator, plant or rig is asked for through, when that is refused, and what becomes of it."""

import time
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from pydantic import ValidationError

from controller.errors import CommandRefused, RigUnreachable
from controller.schema.modes import Mode
from server.access.permit import Permit
from server.hardware.messages import ActuatorOutcome
from server.hardware.restart_files import take_outcome
from server.http.given import given
from server.log.events import EventLog
from server.operate.operator import Operator
from server.recorder.client import RecorderClient
from server.rig.client import Rig
from server.settings import ServerSettings

OUTCOME_S = 0.25
"""Between two looks for an outcome."""
ACTUATOR_MAX_S = 90.0
"""Most time for the rig to come back after an order, be it with the actuator before; then it counts as silent."""


class Awaited(NamedTuple):
    """A rig that was told to start with another actuator."""

    actuator: str
    boot: int | None
    """Boot of the rig that is to end."""
    end: float
    """Until when it may take [s on the monotonic clock]."""


class OutcomeWatch:
    """Tells what became of an order for another actuator."""

    def __init__(self, settings: ServerSettings, events: EventLog) -> None:
        self._settings, self._events = settings, events
        self._blind = False
        self.failure = ""
        """Why the last actuator that was asked for is not in force, "" if it is."""
        self._awaited: Awaited | None = None
        self._settled = False

    def wait_for(self, actuator: str, boot: int | None) -> None:
        """The rig, which runs as `boot`, was told to start with `actuator`."""
        self._settled = self._blind
        self._awaited = Awaited(actuator, boot, time.monotonic() + ACTUATOR_MAX_S)

    def starting(self, boot: int | None) -> str:
        """Actuator with which the rig was told to start and has not yet, "" for none; `boot` is the one heard now.

        It has once it is known how that went, and the boot that came of it is heard.
        """
        wanted = self._awaited
        if wanted is None:
            return ""
        back = self._settled and boot not in (None, wanted.boot)
        if back or time.monotonic() > wanted.end:
            self._awaited = None
            return ""
        return wanted.actuator

    def look(self) -> None:
        """A job: see whether there is one."""
        if self._settings.restarts is None or self._blind:
            return
        try:
            outcome = take_outcome(self._settings.restarts)
        except FileNotFoundError:
            return
        except (OSError, ValidationError) as error:
            self._blind = self._settled = True
            self._events.add(f"what becomes of another actuator will not be told here: {error}", "warning")
            return
        self._tell(outcome)

    def _tell(self, outcome: ActuatorOutcome) -> None:
        self._settled = True
        self.failure = told(outcome) if outcome.reason else ""
        if outcome.reason:
            self._events.add(self.failure, "error")
        elif outcome.unkept:
            self._events.add(f"the next start will not have this actuator: {outcome.unkept}", "warning")


def told(outcome: ActuatorOutcome) -> str:
    """A failed order in one sentence."""
    return f"actuator {outcome.actuator} did not start: {outcome.reason}; {outcome.in_force} is in force again"


GivenOutcomes = Annotated[OutcomeWatch, given(OutcomeWatch)]


@dataclass(frozen=True)
class Change:
    """What another actuator, plant or rig is asked for through."""

    rig: Rig
    outcomes: OutcomeWatch
    recorder: RecorderClient
    operator: Operator
    events: EventLog
    settings: ServerSettings

    def require_rest(self) -> None:
        """Raise CommandRefused unless the rig is VENTED, and nothing is recorded."""
        newest = self.rig.newest
        if self.rig.boot() is None or newest is None:
            raise RigUnreachable("the rig does not answer")
        mode = Mode(newest[0]["mode"])
        if mode != Mode.VENTED:
            raise CommandRefused(f"the actuator cannot be changed in {mode.name}: disarm first")
        if self.recorder.state().recording:
            raise CommandRefused("the actuator cannot be changed while a recording runs: stop it first")

    def requested(self, name: str, what: str, permit: Permit) -> None:
        """`permit` has asked for `what`, called `name`: wait for what becomes of it, and tell everybody."""
        self.outcomes.wait_for(name, self.rig.boot())
        self.events.add(f"{permit.name}: the rig starts again with {what}", "warning")


GivenChange = Annotated[Change, given(Change)]
