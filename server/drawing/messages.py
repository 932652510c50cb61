"""What browser and server say about drawn references and their preview; SI units."""

from datetime import datetime
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, ConfigDict, model_validator
from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.layout import Model
from controller.schema.messages import Coordinate
from controller.text.header import LengthUnit, TimeUnit

Point = tuple[Coordinate, Coordinate]
DURATION_MIN, DURATION_MAX = 0.1, 280.0
"""Of a drawing: the rig's memory holds five minutes, the approach and some laps' way back included [s]."""
POINTS_MAX = 5000
"""Of a drawing."""


def _no_download(name: str) -> str:
    """A drawing may not be named as the download of another one."""
    if name.endswith(".csv"):
        raise ValueError("a name may not end in .csv, which is the download of a drawing")
    return name


DrawingName = Annotated[
    str,
    spelled(
        r"^[A-Za-z0-9_]([A-Za-z0-9_ .-]*[A-Za-z0-9_.-])?$",
        "a name has letters (a to z), digits, blanks and _ . -, and begins with a letter, a digit or _",
        min_length=1,
        max_length=80,
    ),
    AfterValidator(_no_download),
]
"""Letters, digits, blank, _ - . and neither a blank at an end nor a point or - in front."""


class Both(Model):
    """Base of what goes both ways: one type on the page, and whole, though a request may leave defaults out."""

    model_config = ConfigDict(json_schema_mode_override="serialization")


class Speed(Both):
    """Constant speed, corners included."""

    kind: Literal["speed"] = "speed"
    speed: Annotated[float, Bounds(ge=1e-3, le=1.0)]
    """[m/s]."""


class Duration(Both):
    """Constant speed, so that it takes this long."""

    kind: Literal["duration"] = "duration"
    duration: Annotated[float, Bounds(ge=DURATION_MIN, le=DURATION_MAX)]
    """[s]."""


class Fastest(Both):
    """As fast as `speed_max` and `acceleration_max` of the settings in force allow; it slows at corners."""

    kind: Literal["fastest"] = "fastest"


class Given(Both):
    """At the times that came with the points."""

    kind: Literal["given"] = "given"


Timing = Annotated[Speed | Duration | Fastest | Given, Bounds(discriminator="kind")]


class Piece(Both):
    """A stroke of a drawing, and how it lies: what the page needs to move, scale and turn it again."""

    points: Annotated[int, Bounds(ge=2, le=POINTS_MAX)]
    """How many of the drawing's points are its own, after those of the pieces before it."""
    centre: Point
    """About which it is turned and scaled [m]."""
    angle: Annotated[float, Bounds(allow_inf_nan=False)] = 0.0
    """By which it was turned, counter-clockwise [rad]."""
    scale: Annotated[float, Bounds(gt=0.0, allow_inf_nan=False)] = 1.0
    """Of its size against that in which it was drawn."""
    group: Annotated[int, Bounds(ge=0, le=POINTS_MAX)] | None = None
    """Pieces with the same number are selected together."""


class DrawingBody(Both):
    """A drawing, as it is saved and planned."""

    name: DrawingName
    points: Annotated[list[Point], Bounds(min_length=2, max_length=POINTS_MAX, fail_fast=True)]
    """Positions in the plane frame [m]; straight lines lie between them, but for those from one piece to the next."""
    times: (
        Annotated[list[Annotated[float, Bounds(allow_inf_nan=False)]], Bounds(max_length=POINTS_MAX, fail_fast=True)]
        | None
    ) = None
    """Of the points [s], rising; only an imported file has them."""
    closed: bool = False
    """Whether a line leads from the last point back to the first. Not for `given`."""
    smoothing: Annotated[float, Bounds(ge=0.0, le=0.02)] = 0.0
    """How far the path that is followed may be from the drawn one [m]."""
    timing: Timing
    outside: Literal["project", "refuse"] = "project"
    """Where the drawing leaves the reach: follow the nearest points within it, or refuse to run."""
    pieces: Annotated[list[Piece], Bounds(min_length=1, max_length=POINTS_MAX // 2, fail_fast=True)] | None = None
    """The strokes in turn, between which the tip travels unjudged; null: all points are one. Not for `given`, which has
    times for the way, too: there they only say how it was drawn."""

    @model_validator(mode="after")
    def _pieces_fit(self) -> Self:
        if self.pieces is not None and (count := sum(piece.points for piece in self.pieces)) != len(self.points):
            raise ValueError(f"pieces have {count} points in all, but there are {len(self.points)}")
        return self

    @model_validator(mode="after")
    def _times_fit(self) -> Self:
        if self.times is not None:
            if len(self.times) != len(self.points):
                raise ValueError(f"times = {len(self.times)} values, but there are {len(self.points)} points")
            for before, t in pairwise(self.times):
                if t <= before:
                    raise ValueError(f"times = {t:g} s is not after {before:g} s")
        if self.timing.kind == "given":
            if self.times is None:
                raise ValueError("timing.kind = given, but there are no times")
            if self.closed:
                raise ValueError("closed = true, but timing.kind = given has no time for the way back")
        return self


class DrawingPlan(Model):
    """What would be followed, approach left out; at most 2000 rows."""

    length: float
    """Without travel [m]."""
    duration: float
    """Without the approach [s]."""
    approach: float
    """From rest to the first point [s]."""
    travel_duration: float
    """Of the duration on travel: from one stroke to the next, or to another pose of the arm [s]."""
    peak_speed: float
    """Without travel [m/s]."""
    peak_acceleration: float
    """The same [m/s^2], over 20 ms: a corner at constant speed has a finite one; from rest to rest."""
    t: list[float]
    """Times of the rows after the approach [s]."""
    points: list[tuple[float, float]]
    """After smoothing and projection [m]."""
    wished: list[tuple[float, float]]
    """The same rows before the projection [m]."""
    inside: list[bool]
    """Whether the row is within reach."""
    travel: list[bool]
    """Whether the row only leads to the next stroke, or to another pose of the arm: it is not judged."""
    outside_share: float
    """Share of the time out of reach, 0..1."""
    reachable: bool
    """Whether it may run: within reach, or projected."""
    reason: str
    """Why it may not run, or what was projected, retimed or led round; "" where all is followed as it was asked."""


class DrawingInfo(Model):
    """One saved drawing."""

    name: str
    saved: datetime
    length: float
    """Of what was drawn [m]."""
    duration: float | None
    """Of that, without travel [s]; null for `fastest`, which depends on the settings."""
    points: int


class TextBody(Model):
    """Body of POST /api/drawings/text."""

    text: Annotated[str, Bounds(min_length=1, max_length=40)]
    height: Annotated[float, Bounds(ge=1e-3, le=0.5)]
    """Of a capital [m]."""


class TextPath(Model):
    """Single-stroke letters; lower left corner of the text at the origin."""

    strokes: list[list[tuple[float, float]]]
    """What is meant to be seen, each from its end that is nearer to the one before [m]."""
    points: list[tuple[float, float]]
    """One path through all strokes in turn, for a pen that never lifts [m]."""


class ImportChoices(Model):
    """What a person says about a file: which columns are meant, and units that its header leaves open."""

    name: Annotated[str, Bounds(min_length=1, max_length=255)] = "the file"
    """What errors call it."""
    x: Annotated[int, Bounds(ge=0)] | None = None
    """Number of the column, from 1 on, 0 for none; without one the column is found by its name or place."""
    y: Annotated[int, Bounds(ge=0)] | None = None
    t: Annotated[int, Bounds(ge=0)] | None = None
    length_unit: LengthUnit | None = None
    """Of x and y where the header names none."""
    time_unit: TimeUnit | None = None


class ImportedColumn(Model):
    """A column of an imported file."""

    name: Literal["t", "x", "y"]
    title: str
    """As the header has it; the name where there is none."""
    unit: str
    stated: bool
    """Whether the file says the unit; otherwise it was chosen or is assumed."""


class ImportedPath(Model):
    """A path from a file, with what was understood of it; as many points as a drawing holds."""

    points: list[tuple[float, float]]
    """[m]."""
    times: list[float] | None
    """Of the points from the first one on [s]; null where the file has none."""
    header: bool
    """Whether the file names its columns; otherwise they are known by their order."""
    columns: list[ImportedColumn]
    notes: list[str]
    """What was assumed, left out or thinned, a sentence each."""


class ProposedColumn(Model):
    """Any column of a file that may be imported."""

    title: str
    """As the header has it, or its number."""
    name: Literal["t", "x", "y"] | None
    """What it is taken as; null where it is not used."""
    unit: str | None
    """In which it is taken; null where neither the file nor anybody says it."""
    stated: bool
    """Whether the file says the unit."""


class ProposedRow(Model):
    """One of the first rows of the file."""

    line: int
    cells: list[str]
    """As the file has them."""
    t: float | None
    """[s]; null where there is no time, or the row is not understood."""
    point: tuple[float, float] | None
    """[m]; null where the row is not understood."""


class ImportProposal(Model):
    """How a file would be read, before it is."""

    header: bool
    """Whether its first line names the columns."""
    columns: list[ProposedColumn]
    rows: list[ProposedRow]
    count: int
    """Rows of the path; 0 where it is not understood."""
    path: ImportedPath | None
    problem: str
    """Why there is no path: line, column and value of what is wrong; "" where there is one."""
    times_problem: str
    """Why its times cannot be kept; "" where they can, or where there are none."""


class Wanted(Model):
    """What is to be followed: a drawing, or a reference of the library."""

    drawing: DrawingBody | None = None
    reference: Annotated[str, Bounds(min_length=1, max_length=80)] | None = None
    """A name of the library, or its title."""
    K_FF: Literal["published", "settings"] = "published"
    """Published: a reference whose figures were published with velocity feedforward has it where settings have 0."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.drawing is None) == (self.reference is None):
            raise ValueError("give either a drawing or a reference")
        return self


Name = Annotated[str, Bounds(min_length=1, max_length=80)]


class ReferenceInfo(Model):
    """One entry of the reference menu, as the connected rig's actuator has it."""

    name: str
    """What requests give."""
    task: str
    """Group of the menu."""
    title: str
    """What it is called wherever it is shown: in menus, results, recordings and messages."""
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
    K_FF: float
    """Velocity feedforward that it runs with where the settings have 0, as its figures were published [s]."""
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
