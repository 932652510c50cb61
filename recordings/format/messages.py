"""What is said about recordings: the recorder's state and one row of the list."""

from typing import Annotated, Literal

from pydantic import AwareDatetime
from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.schema.parameters import Settings

DISK_TIMEOUT_S = 600.0
"""A disk that takes nothing for so long ends the recording [s]: memory holds the rows of that time."""
SPLIT_BYTES = 1_000_000_000
"""Size at which a recording goes on in another file."""

Profile = Literal["full", "standard"]
"""How much of every tick is kept; `recordings.format.profiles` says what each one holds."""

Level = Literal["info", "warning", "error"]
"""Of a line in a recording's log."""


FAULT = "fault: "
"""How the names of those begin that a fault began."""

BOOKMARKS_MAX = 100
"""Of one recording: every page is told all of them while it runs."""

Label = Annotated[str, Bounds(max_length=80)]


class Bookmark(Model):
    """A place in a recording that someone marked while it ran."""

    n: int
    """Its number in the recording, 1, 2, ...: no other gets it, even if it is removed."""
    tick: int
    """Of the row that was the newest."""
    t: float
    """When that was, since the recording's first row [s]."""
    label: Label = ""


class RecordingState(Model):
    """What the recorder does now."""

    recording: bool
    id: str
    seconds: float
    rows: int
    gaps: int
    """Ticks that are missing between the rows given: 0 when nothing was lost."""
    problem: str = ""
    """What is wrong, "" for nothing: why rows wait in memory, why none may begin, or why the last one ended by itself
    (a full disk, ...).
    """
    origin: float = 0.0
    """The rig's clock at its first row [s]."""
    bookmarks: tuple[Bookmark, ...] = ()
    """Those of the part that is being written."""


class Hole(Model):
    """Ticks that are not in the file."""

    after: int
    """The last tick before it."""
    ticks: int
    """How many are missing."""


class Restart(Model):
    """The rig ended, killed perhaps, and was restarted: its ticks begin again, and none are counted as missing."""

    after: int
    """The last tick of its boot before."""
    seconds: float
    """From that tick to the first of the new boot."""


class Metrics(Model):
    """What a run's rows come to (`recordings.read.metrics`); null where there is nothing to measure. SI units."""

    approach: float | None = None
    """So long runs were led into [s], which does not count; null where the recording does not say, and it counts."""
    rmse: float | None = None
    max_error: float | None = None
    sse: float | None = None
    """Steady-state error: mean length of the error over the last tenth [m] (paper, "SSE")."""
    ise: float | None = None
    """Integral of the squared error over time [m^2 s]."""
    lag_deg_x: float | None = None
    lag_deg_y: float | None = None
    saturated_share: float | None = None
    residual_rms: float | None = None
    """RMS of the observer's residual [m]."""
    unsensed_rms: float | None = None
    """RMS distance between the observer's rods and the twin's at rods that are not sensed [m]; null on hardware."""
    feedback_share: float | None = None
    """Mean |u_fb| / mean (|u_ff| + |u_fb|)."""
    lost: int | None = None
    """Slots of the time grid without their tick."""
    on_time_share: float | None = None


class Recording(Model):
    """One row of the Review tab."""

    id: str
    name: str
    started: AwareDatetime
    seconds: float
    rows: int
    gaps: int
    bytes: int
    actuator: str
    twin: bool
    complete: bool
    """False: the writer was killed; the file is readable up to its last batch."""
    recovered: bool = False
    """The file of a killed writer was mended: it holds what was written, with a proper end."""
    rig: str = ""
    operator: str = ""
    """Who operated when it began, "" for no one."""
    reference: str = ""
    """Name of the library's reference or of the drawing that was run, "" without a run."""
    profile: Profile = "full"
    settings: Settings | None = None
    """Gains, law, limits and sensed rods at the start."""
    holes: tuple[Hole, ...] = ()
    """Where ticks are missing, the first 100."""
    restarts: tuple[Restart, ...] = ()
    """Where the rig restarted while it was recorded, the first 100."""
    part_of: str = ""
    """Id of the first part, of a recording that was split by size; "" for that one and for all others."""
    imported: bool = False
    """It was made elsewhere: time, x and y alone."""
    metrics: Metrics | None = None
    """Null until they were taken, after the end."""
    bookmarks: tuple[Bookmark, ...] = ()
    """What was marked while it ran, in the order of time."""
    thumbnail: str | None = None
    """Its path as SVG path data in a box of 100 x 100, y down; "" where there is none, null until it was made."""
    tags: tuple[str, ...] = ()
    notes: str = ""
    starred: bool = False
    """The quota leaves it where it is."""
    problem: str = ""
    """Why it cannot be relied on: its data or its description is missing or damaged; "" for nearly all."""


def by_itself(recording: Recording) -> bool:
    """Whether a run or a fault began it, after whose end it lasts for some seconds only."""
    return bool(recording.reference) or recording.name.startswith(FAULT)
