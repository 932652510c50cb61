"""The layout that is embedded in every recording: opened with it in any rerun viewer of the same version."""

import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from controller.schema.display import shown
from recordings.format.signals import Group, rgba

APPLICATION = "tendril"
"""Of every recording; rerun applies a layout to those of its own application."""
TRAIL_SECONDS = 2.0


@dataclass(frozen=True)
class Look:
    """How a recording is shown; as it is without any."""

    dark: bool = True
    units_shown: bool = False
    """Plots are in the units that people read, not in SI."""

    def title(self, name: str, *units: str) -> str:
        """Of a plot: `name` with its `units`, SI ones, each in its place as {}."""
        return name.format(*(f"[{shown(unit)[0] if self.units_shown else unit}]" for unit in units))

    @property
    def ground(self) -> list[int]:
        """Of the plan view."""
        return [16, 18, 22] if self.dark else [255, 255, 255]


AS_IT_IS = Look()


@lru_cache(maxsize=8)
def layout(length: float, look: Look = AS_IT_IS) -> bytes:
    """`blueprint` as rerun's own file (.rbl): rerun never gives back what it makes one of, 1.7 MB each time."""
    with tempfile.TemporaryDirectory(prefix="tendril-layout-") as folder:
        file = Path(folder, "layout.rbl")
        blueprint(length, look).save(APPLICATION, file)
        return file.read_bytes()


def blueprint(length: float, look: Look = AS_IT_IS) -> rrb.Blueprint:
    """Plan view, modes and log at the left, plots at the right; `length` [m] of the actuator bounds the plan view."""
    left = rrb.Vertical(_plan(length, look), _modes(), rrb.Tabs(_log(), _about()), row_shares=[5, 1.3, 2.2])
    plots = rrb.Tabs(
        rrb.Vertical(
            _plot("/tip/x", look.title("Tip x {}", "m")),
            _plot("/tip/y", look.title("Tip y {}", "m")),
            _plot("/error", look.title("Error and observer residual {}", "m")),
            name="Tracking",
        ),
        rrb.Vertical(
            _plot("/pressures", look.title("Pressures {}", "Pa")),
            _plot("/u", look.title("Torques {}", "N m")),
            name="Command",
        ),
        rrb.Vertical(
            _plot("/observer", look.title("Observer: energy and its balance {}, powers {}", "J", "W")),
            _plot("/timing", look.title("Loop: wake-up lateness and step time {}", "ns")),
            name="Observer, timing",
        ),
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, plots, column_shares=[2, 3]),
        rrb.TimePanel(state="collapsed", timeline="t", play_state="paused"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_layout=False,
        auto_views=False,
    )


def _plan(length: float, look: Look) -> rrb.Spatial2DView:
    reach = 1.15 * length
    trail = rrb.VisibleTimeRanges(
        timeline="t",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    return rrb.Spatial2DView(
        origin="/plan",
        name="Plan view (grid 50 mm)",
        visual_bounds=rrb.VisualBounds2D(x_range=(-0.6 * length, reach), y_range=(-reach, reach)),
        background=look.ground,
        overrides={"/plan/reference": [trail], "/plan/tip": [trail]},
    )


def _modes() -> rrb.StateTimelineView:
    return rrb.StateTimelineView(origin="/mode", name="Mode", time_view=_whole_time())


def _log() -> rrb.TextLogView:
    columns = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
    return rrb.TextLogView(origin="/log", name="Log", columns=columns)


def _about() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(origin="/about", name="About")


def _plot(path: str, name: str) -> rrb.TimeSeriesView:
    legend = rrb.PlotLegend(corner=rrb.Corner2D.RightTop)
    return rrb.TimeSeriesView(origin=path, name=name, plot_legend=legend, axis_x=_whole_time())


def _whole_time() -> rrb.TimeAxis:
    """The whole recording at first; zooming one plot zooms them all."""
    everything = rrb.TimeRange(rrb.TimeRangeBoundary.infinite(), rrb.TimeRangeBoundary.infinite())
    return rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal, view_range=everything)


def style(group: Group, units_shown: bool = False) -> rr.SeriesLines:
    """Names, colours and widths of the group's lines; the names with units that people read, or with SI ones."""
    return rr.SeriesLines(
        names=[series.shown[0] if units_shown else series.name for series in group.series],
        colors=rgba(series.color for series in group.series),
        widths=[series.width for series in group.series],
    )
