"""What the browser and the server say to each other, once: OpenAPI and the page's TypeScript are made from here.

The live socket carries JSON text both ways and binary frames to the browser:
  uint32 kind, uint32 count, then
  FRAME: one Telemetry record, the newest; `Hello.layout` describes it;
  PLOT: uint32 columns, uint32 first, then float64 t[count] [s on the rig's clock], uint32 channel[columns] (places in
  `Hello.channels`), float32 low[count][columns], float32 high[count][columns]: the extremes of every 1 kHz sample in
  the bins number first, first + 1, ..., so spikes show. Only the channels of the page's PlotChoice are sent.
Little endian. Newest wins: a slow viewer skips frames.
"""

from datetime import datetime
from enum import IntEnum
from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.schema.layout import Field, Model
from controller.schema.messages import CommandReply, Coordinate, RigInfo
from controller.schema.parameters import Settings
from recordings.format.messages import Profile
from recordings.format.messages import Recording as Recording
from recordings.format.messages import RecordingState as RecordingState
from server.plots.messages import PlotChannel, PlotChoice
from server.runs.messages import RunResult, RunState
from server.tokens import Role


class Kind(IntEnum):
    """First word of a binary message."""

    FRAME = 1
    PLOT = 2


Name = Annotated[str, Bounds(min_length=1, max_length=80)]


class Login(Model):
    """Body of POST /api/session: the access token printed by `tendril up`."""

    token: Annotated[str, Bounds(min_length=1, max_length=200)]


class Lease(Model):
    """Who operates. At most one session holds it; it lapses when its page is gone."""

    held: bool
    mine: bool
    holder: str
    """Short name of the holder's session, "" when free."""
    clutch: bool
    """Held clutch: a target moves only while it is held, and letting go holds the rig."""


class Person(Model):
    """A session as others see it."""

    tag: Annotated[str, Bounds(pattern=r"^[0-9a-f]{12}$")]
    """Names the session; its id stays its own."""
    name: str
    role: Role
    """Whose token it signed in with."""


class People(Model):
    """Who is here, and who wants to operate."""

    holder: str
    """Tag of whoever operates, "" when nobody does."""
    asking: list[Person]
    """Who asked for control, the longest waiting first."""
    others: list[Person]
    """Whose pages are open, but mine."""
    waiting: bool
    """I asked, and nobody has answered."""


class SessionTag(Model):
    """Body of requests about another session: which one."""

    tag: Annotated[str, Bounds(pattern=r"^[0-9a-f]{12}$")]


class LeaseBody(Model):
    """Body of PATCH /api/lease: how the holder operates."""

    clutch: bool


class Session(Model):
    """Who I am."""

    name: str
    role: Role
    """Whose token I signed in with."""
    unprotected: bool
    """Other machines can reach this server, and what is said to it travels unencrypted."""
    lease: Lease


class CommandBody(Model):
    """Body of POST /api/command."""

    request: Literal["arm", "hold", "follow", "rest", "clear", "e_stop"]
    target: tuple[Coordinate, Coordinate] | None = None
    """Needed by `follow`; metres in the plane frame."""


class SettingsBody(Model):
    """Body of PATCH /api/settings: only the fields to change (same names and bounds as `Settings`)."""

    changes: Annotated[dict[str, float | int | Annotated[list[float], Bounds(max_length=16)]], Bounds(max_length=64)]


class RecordingBody(Model):
    """Body of POST /api/recordings."""

    name: Annotated[str, Bounds(max_length=80)] = ""
    profile: Profile = "standard"


class Workspace(Model):
    """Reach of the observer's static map over the admissible torques (box and coupled bend limit): image of a u-grid.

    Quads between neighbouring grid points, filled, show the reach with its hole.
    """

    rows: int
    columns: int
    points: list[tuple[float, float]]
    """Row-major tip positions [m]."""
    length: float
    """Backbone length [m]."""


class ReferenceInfo(Model):
    """One entry of the reference menu, as the connected rig's actuator has it."""

    name: str
    task: str
    """Group of the menu."""
    title: str
    duration: float
    """Without the approach [s]."""
    approach: float
    """From rest to the first point, and any wait there [s]; 0 for a path that is followed live."""
    length: float
    """Path length without the approach [m], every lap of a periodic shape counted."""
    peak_speed: float | None
    """Without the approach [m/s]; null where the reference jumps. Of a recorded path over 0.25 s."""
    frequency: float | None
    """Of a periodic shape [Hz]."""
    reachable: bool
    reason: str
    """Why it is not reachable, "" if it is."""


class ReferencePath(Model):
    """Points of a reference for drawing, at most 2000; between them lie straight lines."""

    name: str
    t: list[float]
    """Times of the points [s], approach included."""
    points: list[tuple[float, float]]
    """Positions [m]."""
    start: int
    """Index of the first point after the approach."""


class Health(Model):
    """The page's health strip: everything that is not in a telemetry row."""

    rig_connected: bool
    rig_age: float
    """Seconds since the last telemetry batch [s]; large when the rig is gone."""
    link_rtt: float
    """Median round trip server -> rig loop -> server of the last commands [s]."""
    viewers: int
    trouble: str
    """Why the rig takes no command from this server (another version, key, or server), "" when it does."""
    server: str = ""
    """What in the server itself does not work: a thread, a look at every beat, its event loop; "" when all does."""


class Event(Model):
    """One line of the log: who did what, and what was refused."""

    type: Literal["event"] = "event"
    time: datetime
    level: Literal["info", "warning", "error"]
    text: str


class Hello(Model):
    """First message on the live socket."""

    type: Literal["hello"] = "hello"
    session: Session
    layout: list[Field]
    channels: list[PlotChannel]
    page: str
    """Names this live socket; the page's worker gives its signs of presence for it."""
    rig: RigInfo | None
    log: list[Event]
    """What happened so far, oldest first."""


class Status(Model):
    """Sent at every change and once a second."""

    type: Literal["status"] = "status"
    lease: Lease
    people: People
    settings: Settings
    recording: RecordingState
    health: Health
    rig: RigInfo | None
    run: RunState | None
    """The run under way, or how the last one ended; null before this server's first."""
    result: RunResult | None
    """Of the last run that ended, this server's or an earlier one's."""


class Reply(Model):
    """Answer to a Target or an EStop: what the rig did with it."""

    type: Literal["reply"] = "reply"
    id: int
    """Of the Target; 0 for an EStop."""
    reply: CommandReply
    n: int | None = None
    """Of the EStop; null for a Target."""


class Refused(Model):
    """A message on the socket was refused before it reached the rig."""

    type: Literal["refused"] = "refused"
    id: int
    detail: str
    n: int | None = None
    """Of the EStop that did not arrive; null for anything else."""


class Pong(Model):
    """Answer to Ping."""

    type: Literal["pong"] = "pong"
    t: float


class Target(Model):
    """The operator moved the target. `start` marks a fresh action (press): only it may leave HOLD."""

    type: Literal["target"]
    id: Annotated[int, Bounds(ge=0)]
    x: Coordinate
    y: Coordinate
    start: bool = False


class Release(Model):
    """The operator let go of the target: with the held clutch on, the rig then holds."""

    type: Literal["release"]
    hold: bool = False
    """Hold whatever the clutch is: the page ended the drag, because its plan moved under the pointer."""


class EStop(Model):
    """Stop the rig at once: anyone who is signed in may, however often. Answered by a Reply, or Refused, with its n."""

    type: Literal["e_stop"]
    n: Annotated[int, Bounds(ge=0, lt=2**53)]


class Presence(Model):
    """The operator's page is alive: a counter that only it advances, sent at 20 Hz while it holds the lease.

    The page says so on /ws/presence, from a worker; a script may on its live socket.
    """

    type: Literal["presence"]
    n: Annotated[int, Bounds(ge=0)]


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


FromServer = Annotated[Hello | Status | Reply | Refused | Pong | Event, Bounds(discriminator="type")]
FromBrowser = Annotated[Target | Release | EStop | Presence | Ping | PlotChoice, Bounds(discriminator="type")]
