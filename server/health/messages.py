"""From where on a figure of the Health tab is to be watched (amber) or bad (red), and what a webhook is told."""

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import Field as Bounds
from pydantic import model_validator

from controller.schema.layout import Model
from server.runs.messages import RunResult

Duration = Annotated[float, Bounds(ge=1e-5, le=10.0)]
Distance = Annotated[float, Bounds(ge=1e-5, le=0.2)]
Ticks = Annotated[float, Bounds(ge=1, le=60_000)]
Share = Annotated[float, Bounds(ge=0.0, le=1.0)]


class Limit(Model):
    """Two limits that a figure passes on its way up: first amber, then red."""

    amber: float
    red: float

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.amber <= self.red:
            raise ValueError(f"amber = {self.amber:g} is above red = {self.red:g}")
        return self

    @property
    def side(self) -> str:
        """On which side of a limit it is beyond."""
        return "above"

    def passed(self, value: float, limit: float) -> bool:
        """Whether `value` is beyond `limit`; nan is not."""
        return value > limit


class DurationLimit(Limit):
    """Of a time [s]."""

    amber: Duration
    red: Duration


class DistanceLimit(Limit):
    """Of a distance [m]."""

    amber: Distance
    red: Distance


class TicksLimit(Limit):
    """Of a number of ticks."""

    amber: Ticks
    red: Ticks


class ShareLimit(Limit):
    """Of a share that is passed on its way down."""

    amber: Share
    red: Share

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.amber >= self.red:
            raise ValueError(f"amber = {self.amber:g} is below red = {self.red:g}")
        return self

    @property
    def side(self) -> str:
        """On which side of a limit it is beyond."""
        return "below"

    def passed(self, value: float, limit: float) -> bool:
        """Whether `value` is beyond `limit`; nan is not."""
        return value < limit


class AlarmLimits(Model):
    """Body of PUT /api/alarms: all limits of one user."""

    round_trip: DurationLimit = DurationLimit(amber=0.05, red=0.15)
    """Page to server and back."""
    command_age: DurationLimit = DurationLimit(amber=0.25, red=0.5)
    """Since the rig's last command, new or repeated."""
    lateness_p99: DurationLimit = DurationLimit(amber=0.3e-3, red=1e-3)
    """Wake-up of 99 of 100 ticks of the last 10 s."""
    lost_ticks: TicksLimit = TicksLimit(amber=60, red=600)
    """In the last minute."""
    on_time: ShareLimit = ShareLimit(amber=0.999, red=0.99)
    """Share of slots with a tick in the last minute."""
    residual: DistanceLimit = DistanceLimit(amber=3e-3, red=8e-3)
    """Measured minus observer, RMS over the sensed rods."""


class Notice(Model):
    """Body of the POST, as JSON. It holds no token, and nothing by which one could sign in."""

    event: Literal["fault", "e_stop", "run_end"]
    rig: str
    time: datetime
    """UTC."""
    text: str
    """One sentence for people."""
    cause: str
    """Why the rig is in FAULT or E-STOP, or why the run ended; "" where nothing is to be said."""
    run: RunResult | None = None
    """What came of the run; null for anything else."""
