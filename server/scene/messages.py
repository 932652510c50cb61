"""What a page says about its own 3D view, and what it hears of a recording played there."""

from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.schema.messages import Coordinate

View = Literal["top", "oblique"]
Scheme = Literal["dark", "light"]
Role = Literal["reference", "ghost", "outside"]
SeatId = Annotated[str, Bounds(pattern=r"^[a-z0-9]{8,40}$")]
"""Chosen by the page at random; one for each frame that shows the 3D view."""


class SeatLook(Model):
    """Body of PUT /api/scene/{seat}/look."""

    scheme: Scheme
    view: View | None = None
    """Put the camera there; null leaves it where it is."""


Line = Annotated[list[tuple[Coordinate, Coordinate]], Bounds(min_length=1, max_length=5000, fail_fast=True)]


class SeatPath(Model):
    """Body of PUT /api/scene/{seat}/path/{role}: what the plan view beside it shows."""

    lines: Annotated[list[Line], Bounds(max_length=100, fail_fast=True)]
    """Points of each line [m]; empty: nothing is shown."""


class PlaybackBody(Model):
    """Body of PUT /api/scene/{seat}/playback."""

    recording: Annotated[str, Bounds(max_length=100)]
    at: Annotated[float, Bounds(ge=0.0, le=1e6)] = 0.0
    """Time in the recording [s]; clipped at its end."""
    playing: bool = True
    rate: Annotated[float, Bounds(ge=0.1, le=10.0)] = 1.0
    """Seconds of the recording a second."""


class Playback(Model):
    """A recording in one 3D view, on the server's clock."""

    recording: str
    at: float
    """Now [s]."""
    duration: float
    playing: bool
    rate: float
