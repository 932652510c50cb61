"""The layout that is embedded in every recording: opened with it in any rerun viewer of the same version."""

import rerun.blueprint as rrb

TRAIL_SECONDS = 2.0


def blueprint(length: float) -> rrb.Blueprint:
    """Plan view and log at the left, plots at the right; `length` [m] of the actuator sets the plan view's bounds."""
    left = rrb.Vertical(
        _plan(length),
        rrb.StateTimelineView(origin="/mode", name="Mode"),
        rrb.Tabs(
            rrb.TextLogView(origin="/log", name="Log"),
            rrb.TextDocumentView(origin="/about", name="About"),
        ),
        row_shares=[6, 1, 2],
    )
    tracking = rrb.Vertical(
        _plot("/tip/x", "Tip x [m]"),
        _plot("/tip/y", "Tip y [m]"),
        _plot("/error", "Error and observer residual [m]"),
        _plot("/pressures", "Chamber pressures [Pa]"),
        name="Tracking",
    )
    inside = rrb.Vertical(
        _plot("/u", "Command u [N m]"),
        _plot("/observer", "Observer: energy [J], powers [W]"),
        _plot("/timing", "Timing of the loop [ns]"),
        name="Command, observer, timing",
    )
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Tabs(tracking, inside), column_shares=[2, 3]),
        rrb.TimePanel(state="collapsed", timeline="t", play_state="paused"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_layout=False,
        auto_views=False,
    )


def _plan(length: float) -> rrb.Spatial2DView:
    reach = 1.15 * length
    trail = rrb.VisibleTimeRanges(
        timeline="t",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    return rrb.Spatial2DView(
        origin="/plan",
        name="Plan view (grid 50 mm)",
        visual_bounds=rrb.VisualBounds2D(x_range=(-0.5 * reach, reach), y_range=(-reach, 0.5 * reach)),
        background=[16, 18, 22],
        overrides={"/plan/reference": [trail], "/plan/tip": [trail]},
    )


def _plot(path: str, name: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(origin=path, name=name, plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop))
