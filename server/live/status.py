"""Everything slow that a page shows, as its session sees it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from server.access.lease import OperatorLease
from server.hardware.first_mode.measurement import FirstModeMeasurement
from server.hardware.outcomes import OutcomeWatch
from server.health.energy_balance import EnergyBalance
from server.health.on_time import OnTime
from server.http.given import given
from server.http.headers import server_time
from server.http.who import Identity
from server.live.messages import Health, Status
from server.operate.operator import Operator
from server.operate.pages import Pages
from server.operate.people import PeopleHere
from server.recorder.client import RecorderClient
from server.rig.client import Rig
from server.runs.macros.macros import Macros
from server.runs.runs import Runs


@dataclass(frozen=True)
class StatusView:
    """Reads the parts. `trouble` is what in the server itself does not work."""

    rig: Rig
    lease: OperatorLease
    people: PeopleHere
    pages: Pages[Any]
    operator: Operator
    recorder: RecorderClient
    runs: Runs
    macros: Macros
    outcomes: OutcomeWatch
    first_mode: FirstModeMeasurement
    on_time: OnTime
    energy: EnergyBalance
    trouble: Callable[[], str]

    def health(self) -> Health:
        """What is not in a telemetry row."""
        return Health(
            rig_connected=self.rig.boot() is not None,
            rig_age=self.rig.age,
            paused=self.rig.paused,
            link_rtt=self.rig.round_trip,
            viewers=len(self.pages.open),
            trouble=self.rig.trouble,
            starting=self.outcomes.starting(self.rig.boot()),
            on_time=_known(self.on_time.share),
            lost=_known(self.on_time.lost),
            energy_balance=_known(self.energy.gained),
            server=self.trouble(),
        )

    def status(self, who: Identity) -> Status:
        """All of it."""
        return Status(
            read_at=server_time(),
            lease=self.lease.view(who),
            people=self.people.view(who),
            settings=self.operator.settings,
            recording=self.recorder.state(),
            health=self.health(),
            rig=self.rig.info,
            stopped_by=self.operator.stopper.by,
            missed=self.people.missed,
            run=self.runs.state(),
            result=self.runs.last(),
            macro=self.macros.state(),
            first_mode=self.first_mode.state(),
        )

    def sight(self, who: Identity) -> str:
        """What of it is not the same for all."""
        return self.lease.view(who).model_dump_json() + self.people.view(who).model_dump_json()

    def key(self) -> object:
        """Differs whenever viewers should be told at once."""
        recording, info = self.recorder.state(), self.rig.info
        return (
            self.lease.clutch,
            self.people.key(),
            self.operator.settings,
            (recording.recording, recording.id, recording.bookmarks),
            self.operator.stopper.by,
            (self.rig.boot(), info.boot if info else None, self.rig.trouble, self.rig.paused),
            len(self.pages.open),
            self.runs.key(),
            self.macros.state(),
            self.first_mode.state(),
            self.outcomes.starting(self.rig.boot()),
            self.trouble(),
        )


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


GivenStatusView = Annotated[StatusView, given(StatusView)]
