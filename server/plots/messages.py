"""What pages say and hear about plots."""

from enum import IntEnum
from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.layout import Model
from server.rig.messages import ChannelKey

CHANNELS_MAX = 48
"""Most channels that one page can follow: with ten minutes of them it holds 15 MB."""

LayoutName = Annotated[str, spelled(r"^[\w .+()-]{1,40}$", "1 to 40 letters, digits, blanks and _ . + - ( )")]


class PlotChoice(Model):
    """The page shows these channels now: it gets their past once, then every new bin; it gets no other channel."""

    type: Literal["plots"]
    channels: Annotated[list[ChannelKey], Bounds(max_length=CHANNELS_MAX)]
    since: Annotated[float, Bounds(allow_inf_nan=False)] | None = None
    """Time of the newest bin that the page still has of all of them [s, rig clock]; null: it has none."""


class Plot(Model):
    """One plot of a layout."""

    title: Annotated[str, Bounds(max_length=40)]
    """Shown above it; "" names it by its signals."""
    channels: Annotated[list[ChannelKey], Bounds(max_length=12)]


class PlotLayout(Model):
    """What a page plots, from left to right, and the length of its time window [s]."""

    seconds: Annotated[float, Bounds(ge=5, le=600)]
    plots: Annotated[list[Plot], Bounds(max_length=8)]


class Kind(IntEnum):
    """First word of a binary message."""

    FRAME = 1
    PLOT = 2
