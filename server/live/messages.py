"""What the browser and the server say to each other, once: OpenAPI and the page's TypeScript are made from here.

The live socket carries JSON text both ways and binary frames to the browser:
  uint32 kind, uint32 count, then
  FRAME: one Telemetry record, the newest; `Hello.layout` describes it;
  PLOT: uint32 columns, uint32 first, then float64 t[count] [s on the rig's clock], uint32 channel[columns] (places in
  `Hello.channels`), float32 low[count][columns], float32 high[count][columns]: the extremes of every 1 kHz sample in
  the bins number first, first + 1, ..., so spikes show. Only the channels of the page's PlotChoice are sent.
Little endian. Newest wins: a slow viewer skips frames.
"""

from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.schema.layout import Field, Model
from controller.schema.messages import CommandReply, RigInfo
from controller.schema.parameters import Settings
from recordings.format.messages import RecordingState
from server.access.messages import Lease, Session
from server.hardware.first_mode.messages import FirstModeState
from server.log.events import LogEntry
from server.operate.messages import EStop, People, Presence, Refused, Release, Target
from server.plots.messages import PlotChoice
from server.rig.messages import PlotChannel
from server.runs.macros.messages import MacroState
from server.runs.messages import RunResult, RunState


class Health(Model):
    """The page's health strip: everything that is not in a telemetry row."""

    rig_connected: bool
    rig_age: float
    """Seconds since the last telemetry batch [s]; large when the rig is gone."""
    link_rtt: float
    """Median round trip server -> rig loop -> server of the last commands [s]."""
    paused: bool = False
    """The twin's time stands still: no telemetry comes, and nothing is wrong."""
    viewers: int
    trouble: str
    """Why the rig takes no command from this server (another version, key, or server), "" when it does."""
    starting: str = ""
    """Actuator with which the rig was told to start again and has not yet, "" for none."""
    on_time: float | None = None
    """Share of the rig's slots in which its loop ticked, over the last minute, in [0, 1]; null before 5 s were seen."""
    lost: float | None = None
    """Slots of the same time without a tick."""
    energy_balance: float | None = None
    """What the observer's energy gained in the last 10 s beyond what its powers gave it [J], which is the integrator's
    error; null where ticks were lost meanwhile, or the observer was set anew."""
    server: str = ""
    """What in the server itself does not work: a thread, a job of its event loop, that loop; "" when all does."""


class Hello(Model):
    """First message on the live socket."""

    type: Literal["hello"] = "hello"
    session: Session
    layout: list[Field]
    channels: list[PlotChannel]
    page: str
    """Names this live socket; the page's worker gives its signs of presence for it."""
    rig: RigInfo | None
    log: list[LogEntry]
    """What happened so far, oldest first."""


class Status(Model):
    """Sent at every change and once a second."""

    type: Literal["status"] = "status"
    read_at: float
    """By the clock of `tendril-time` [s]: what was read before an answer is older, even if it comes later."""
    lease: Lease
    people: People
    settings: Settings
    recording: RecordingState
    health: Health
    rig: RigInfo | None
    stopped_by: str
    """Who pressed the E-STOP in which the rig is, "" where no one did by this server."""
    missed: str
    """Whose sign of presence the rig missed when it last held for lack of one, and why; "" before."""
    run: RunState | None
    """The run under way, or how the last one ended; null before this server's first."""
    result: RunResult | None
    """Of the last run that ended, this server's or an earlier one's."""
    macro: MacroState | None
    """The macro under way, or how the last one ended; null before this server's first."""
    first_mode: FirstModeState | None
    """The measurement of the first mode that goes on, or how the last one ended; null before this server's first."""


class Reply(Model):
    """Answer to a Target or an EStop: what the rig did with it."""

    type: Literal["reply"] = "reply"
    id: int
    """Of the Target; 0 for an EStop."""
    reply: CommandReply
    n: int | None = None
    """Of the EStop; null for a Target."""


class Pong(Model):
    """Answer to Ping."""

    type: Literal["pong"] = "pong"
    t: float


class Heard(Model):
    """Answer to Presence on /ws/presence: the socket is alive."""

    type: Literal["heard"] = "heard"
    n: int


class Ping(Model):
    """For the page's round trip display; t is echoed."""

    type: Literal["ping"]
    t: Annotated[float, Bounds(allow_inf_nan=False)]
    round_trip: Annotated[float, Bounds(ge=0.0, le=3600.0, allow_inf_nan=False)] | None = None
    """What the last ping and its answer took [s]; null before the first."""


FromServer = Annotated[Hello | Status | Reply | Refused | Pong | LogEntry, Bounds(discriminator="type")]
FromBrowser = Annotated[Target | Release | EStop | Presence | Ping | PlotChoice, Bounds(discriminator="type")]
