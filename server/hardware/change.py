"""What another actuator, plant or rig is ordered through, and when that is refused."""

from dataclasses import dataclass
from typing import Annotated

from controller.errors import CommandRefused, RigUnreachable
from controller.schema.modes import Mode
from server.access.permit import Permit
from server.hardware.outcomes import OutcomeWatch
from server.http.given import given
from server.log.events import EventLog
from server.operate.operator import Operator
from server.recorder.client import RecorderClient
from server.rig.client import Rig
from server.settings import ServerSettings


@dataclass(frozen=True)
class Change:
    """What another actuator, plant or rig is ordered through."""

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

    def ordered(self, name: str, what: str, permit: Permit) -> None:
        """`permit` has ordered `what`, called `name`: wait for what becomes of it, and tell everybody."""
        self.outcomes.wait_for(name, self.rig.boot())
        self.events.add(f"{permit.name}: the rig starts again with {what}", "warning")


GivenChange = Annotated[Change, given(Change)]
