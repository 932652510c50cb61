"""What is said about runs: what to run, how it goes, and what came of it. SI units."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.layout import Model
from server.drawing.messages import Wanted

Laps = Annotated[int, Bounds(ge=1, le=1000)]
Phase = Literal["approach", "running", "paused", "done", "stopped", "broken off"]
"""The last three are ends: of itself, by an operator, by the rig."""


Learning = Literal["off", "frozen", "on", "anew"]
"""Follow as planned, or as the best repeat was; repeat and learn from it; the same, and forget what was learned."""


class RunBody(Wanted):
    """Body of POST /api/run: what to follow, and how often."""

    laps: Laps | None = 1
    """Null: until stopped."""
    record: bool = True
    """The run gets a recording of its own, from before its approach to its end, unless one is going on."""
    learning: Learning = "frozen"
    """What is done with what was learned of this path; learning needs a controller that follows a plan."""


class LearnBody(Wanted):
    """Body of POST /api/run/learn: what to repeat, so that it is learned."""

    laps: Annotated[int, Bounds(ge=1, le=1000)] = 1
    record: bool = True
    repeats: Annotated[int, Bounds(ge=1, le=50)] = 8
    anew: bool = False
    """Forget first what was learned of it."""

    def runs(self) -> list[RunBody]:
        """Them."""
        body = RunBody(**self.model_dump(exclude={"repeats", "anew"}), learning="on")
        first = body.model_copy(update={"learning": "anew"}) if self.anew else body
        return [first, *[body] * (self.repeats - 1)]


class PreviewBody(Wanted):
    """Body of POST /api/preview: what to foresee, and how often it is followed."""

    laps: Annotated[int, Bounds(ge=1, le=100)] = 1
    learning: Literal["off", "frozen"] = "frozen"
    """Foresee as planned, or as the best repeat was."""


class Preview(Model):
    """What the twin of the connected rig makes of a reference from where that stands, with the settings in force."""

    t: list[float]
    """Times of the rows [s], approach included; at most 2000."""
    points: list[tuple[float, float]]
    """Predicted tip [m]."""
    start: int
    """Index of the first row after the approach."""
    rmse: float | None
    """After the approach [m]; null where the run is broken off."""
    max_error: float | None
    """[m]."""
    saturated: list[bool]
    """Whether the command saturates at or since the row before."""
    saturated_share: float
    """Share of the time, 0..1."""
    lag_deg_x: float | None
    """Phase lag of a periodic reference [deg]."""
    lag_deg_y: float | None
    approach: list[tuple[float, float]]
    """The reference on its way to the first point, from where the rig stands [m]; the rig is led along it."""
    K_FF: tuple[float, float]
    """Velocity feedforward in x and y that it is followed with [s]: the settings', or the reference's own."""
    broken_off: str
    """Why and when the rig would not follow to the end, "" if it would; the rows then end there."""
    seconds: float
    """Of computing [s]."""


class PreviewPart(Model):
    """A line of the answer to POST /api/preview/parts: what was foreseen since the line before."""

    first: int
    """Index of the first of these rows; what was said of it and later ones before does not hold any more."""
    t: list[float]
    """Times of these rows [s], approach included."""
    points: list[tuple[float, float]]
    """Predicted tip [m]."""
    saturated: list[bool]
    """Whether the command saturates at or since the row before."""
    start: int
    """Index of the first row after the approach."""
    progress: float
    """0..1 of all rows."""
    preview: Preview | None
    """The whole, in the last line."""
    problem: str
    """Why this is the last line though it is not over, "" otherwise."""


class RunState(Model):
    """How the last run goes, or how it ended."""

    id: int
    name: str
    """Of the drawing, or the reference's title."""
    state: Phase
    reason: str
    """Why it was paused or ended, "" while nothing is to be said."""
    lap: int
    """From 1 on; of a paused run the lap in which it was paused."""
    laps: int | None
    elapsed: float
    """In motion since the run began, approach included [s]."""
    duration: float
    """Of one lap, the way back to its start included [s]."""
    progress: float
    """0..1 of all laps; of this lap where `laps` is null."""
    error: float | None
    """Distance of the measured tip from the reference now [m]; null unless the rig tracks and sees its marker."""
    error_rms: float | None
    """Over the ticks after the approach so far [m]; null before the first."""
    recording: str | None
    """The recording that was going on when the run began."""


LessonKey = Annotated[str, spelled(r"^[0-9a-f]{24}$", "24 digits and letters from a to f")]
"""Of a path, an arm, a controller and its gains."""


class Learned(Model):
    """What was learned of a path by repeating it."""

    key: LessonKey
    learning: bool
    """The run was a repeat from which it was learned; else it followed as the best one did."""
    errors: tuple[float | None, ...]
    """RMSE of every repeat so far [m], the run's own the last where it is one; null for one that was broken off."""


class Figures(Model):
    """What a run's ticks come to; null where there was nothing to measure."""

    rmse: float | None
    """[m]; null where the shape was not reached."""
    max_error: float | None
    """[m]"""
    lag_deg_x: float | None
    """Phase lag of the tip; null where the path is not periodic, or the run was shorter than a period."""
    lag_deg_y: float | None
    saturated_share: float | None
    """Share of ticks in which the command was clamped."""
    on_time_share: float | None
    """Share of the time grid's slots that had their tick."""


class RunResult(Figures):
    """What came of a run. The tip is the measured one (`p_meas`), on the twin too: it is what an operator's rig sees.

    Taken over every tick after the approach, without pauses and what it takes to come back from them.
    """

    id: int
    name: str
    """Of the drawing, or the reference's title."""
    time: datetime
    """When it began."""
    laps: float
    """How many were done; a part counts."""
    state: Phase
    reason: str
    duration: float
    """In motion, approach included [s]."""
    K_FF: tuple[float, float] = (0.0, 0.0)
    """Velocity feedforward in x and y that it began with [s]: the settings', or the reference's own."""
    controller: str = ""
    """That was in the slot; "" of a run before there was one."""
    learned: Learned | None = None
    """Null: it was followed as planned."""
    errors: tuple[float | None, ...] = ()
    """Largest error [m] in each of at most 128 equal parts, the last perhaps shorter; null where no tip was seen."""
    recording: str | None
