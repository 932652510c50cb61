"""What pages are told of the rig's reach and of its signals."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model

ChannelKey = Annotated[str, Bounds(pattern=r"^[\w.]{1,40}$")]
"""Names a channel: its field, and the place in it."""


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


class PlotChannel(Model):
    """One signal that can be plotted: an element of a telemetry field, or the field's norm (index null)."""

    key: ChannelKey
    group: str
    """The field in words."""
    name: str
    """The element within the group, "" where the field is one number."""
    unit: str
    """SI; `1` where there is none."""
    field: str
    index: int | None
