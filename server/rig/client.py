"""The rig as the server sees it: which boot of it is connected, and where its rows go."""

from collections.abc import Callable
from typing import Annotated

from controller.arrays import Rows
from controller.errors import RigUnreachable
from controller.link import PlannedRows, RigClient
from controller.schema.actuator import Actuator
from controller.schema.hardware import Drivers
from controller.schema.messages import CommandReply, RigInfo, TwinFaults, TwinTime
from controller.schema.parameters import RigParameters
from controller.system.keys import read_key
from controller.system.thread import SupervisedThread
from recordings.live.channel import Seen
from server.access.permit import Permit
from server.http.given import given
from server.rig.history import History
from server.settings import ServerSettings

AGE_MAX = 86400.0


class Rig:
    """One rig behind the link, whose rows go into `history`."""

    def __init__(self, settings: ServerSettings, history: History) -> None:
        """Connect; KeyRefused where the file of the rig's key cannot be used."""
        self._history, self._endpoint = history, settings.endpoint
        self._boot: int | None = None
        self._link = RigClient(
            settings.endpoint,
            settings.rig,
            history.add,
            self._born,
            key=read_key(settings.key),
            tls=settings.link_tls,
        )
        self.send = self._link.command
        """Send a command and wait for the loop's answer; see `RigClient.command`."""
        self.boot = self._link.boot
        """The boot of the rig that is connected now; None while there is none."""

    @property
    def info(self) -> RigInfo | None:
        """Who the rig is (or was, while it is gone); None before the first contact."""
        return self._link.info

    def require_info(self) -> RigInfo:
        """The same; `RigUnreachable` before the first contact."""
        if self.info is None:
            raise RigUnreachable(f"no rig was heard yet at {self._endpoint}")
        return self.info

    def operator_timeout(self) -> float:
        """For how long the rig takes a sign of the operator's page [s]."""
        return (self.info.parameters if self.info else RigParameters()).limits.operator_timeout

    def actuator(self) -> Actuator:
        """The rig's actuator; the default one before the first contact."""
        return self._link.info.parameters.actuator if self._link.info else RigParameters().actuator

    @property
    def newest(self) -> Rows | None:
        """The newest telemetry row as an array of length 1; None before the first of this boot."""
        return self._history.newest

    @property
    def age(self) -> float:
        """Time since the last telemetry [s]."""
        return min(self._link.age(), AGE_MAX)

    @property
    def round_trip(self) -> float:
        """Median time of the last commands to the loop and back [s]; 0 before the first."""
        return self._link.rtt()

    @property
    def paused(self) -> bool:
        """The twin's time stands still: the rig answers, and no rows come."""
        return self._link.paused and self.boot() is not None

    @property
    def worker(self) -> SupervisedThread:
        """The link's thread, which brings the rows."""
        return self._link.worker

    @property
    def lost_rows(self) -> int:
        """Ticks that the rig's ring no longer held when they could be fetched."""
        return self._link.gaps

    @property
    def trouble(self) -> str:
        """Why the rig takes no command from this server, "" when it does; see `RigClient.trouble`."""
        return str(self._link.trouble or "")

    def stop(self, number: int, boot: int, by: str) -> CommandReply:
        """Send an E-STOP past everything; see `RigClient.stop`."""
        return self._link.stop(number, boot, by)

    def send_stop(self, number: int, boot: int, by: str) -> Callable[[], CommandReply] | None:
        """Send one and wait for nothing; see `RigClient.send_stop`."""
        return self._link.send_stop(number, boot, by)

    @property
    def met(self) -> int | None:
        """The boot of the rig that was met last, heard now or not."""
        return self._boot

    def seen(self) -> Seen | None:
        """The newest row that came from this boot, for who has its own link to the rig."""
        newest = self._history.newest
        return None if newest is None or self._boot is None else Seen(self._boot, int(newest[0]["tick"]))

    def plan(self, rows: PlannedRows, permit: Permit) -> None:
        """Give the rig the reference of its next TRACK run, if `permit` stands; see `RigClient.plan`."""
        permit.require()
        self._link.plan(rows)

    def faults(self) -> TwinFaults:
        """What is injected into the twin; see `RigClient.faults`."""
        return self._link.faults()

    def inject(self, wanted: TwinFaults, permit: Permit) -> TwinFaults:
        """Inject faults into the twin, if `permit` stands; those in force."""
        permit.require()
        return self._link.faults(wanted)

    def time(self) -> TwinTime:
        """How the twin's time goes; see `RigClient.time`."""
        return self._link.time()

    def set_time(self, wanted: TwinTime, permit: Permit) -> TwinTime:
        """Let the twin's time stand still or go on, if `permit` stands."""
        permit.require()
        return self._link.time(wanted)

    def drivers(self) -> Drivers:
        """How the rig's devices fare; see `RigClient.drivers`."""
        return self._link.drivers()

    def close(self) -> None:
        """End the link; no row comes after this."""
        self._link.close()

    def _born(self, info: RigInfo) -> None:
        self._history.forget()
        self._boot = info.boot


GivenRig = Annotated[Rig, given(Rig)]
