"""How the report draws: one look per role (those of the page and of recordings), axes in mm, s, kPa and deg."""

from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from controller.arrays import Array
from controller.schema import palette
from controller.schema.palette import css

MM = 1e3
"""Millimetres in a metre."""
KPA = 1e-3
"""Kilopascals in a pascal."""
EVERY = 10e-3
"""Time between the points of a curve [s]: more cannot be seen."""

REFERENCE: Any = {"color": css(palette.REFERENCE), "linestyle": (0, (4, 2)), "linewidth": 1.3, "zorder": 4}
TIP: Any = {"color": css(palette.TWIN), "linestyle": "-", "linewidth": 2.2, "zorder": 2}
"""The twin's true tip."""
OBSERVER: Any = {"color": css(palette.OBSERVER), "linestyle": "-", "linewidth": 1.0, "zorder": 3}
PAPER: Any = {
    "color": css(palette.DANGER),
    "linestyle": "none",
    "marker": "x",
    "markersize": 6.0,
    "markeredgewidth": 1.6,
}
"""A number of the paper."""

_FIRST: Any = {"color": "#000000", "linestyle": ":", "linewidth": 1.3}
_SECOND: Any = {"color": "#0072B2", "linestyle": "-.", "linewidth": 1.1}
_THIRD: Any = {"color": "#882255", "linestyle": (0, (5, 1.5)), "linewidth": 1.1, "zorder": 3}
"""Above the next, so that both are seen where they are one."""
_FOURTH: Any = {"color": "#117733", "linestyle": "-", "linewidth": 1.1}
LAWS = {
    "ff": _FIRST,
    "ff+p": _SECOND,
    "ff+i": _THIRD,
    "ff+pi": _FOURTH,
    "rod6": _SECOND,
    "rod10": _THIRD,
    "rod6+10": _FOURTH,
}
"""The tip under each law or choice of sensors, where several are in one drawing."""
LAW_NAMES = {
    "ff": "FF",
    "ff+p": "FF+P",
    "ff+i": "FF+I",
    "ff+pi": "FF+PI",
    "rod6": "rod 6",
    "rod10": "rod 10",
    "rod6+10": "rods 6+10",
}


def stride(t: Array, every: float = EVERY) -> slice:
    """Which of the even times t (n,) [s] are drawn."""
    return slice(None, None, max(1, round(every / (t[1] - t[0])))) if len(t) > 1 else slice(None)


def over_time(axes: Axes, t: Array, y: Array, look: Any, label: str = "") -> None:
    """A curve y (n,) over t (n,) [s], thinned."""
    part = stride(t)
    axes.plot(t[part], y[part], label=label, **look)


def in_plane(axes: Axes, p: Array, look: Any, label: str = "") -> None:
    """A path p (n,2) [m] in mm."""
    axes.plot(p[:, 0] * MM, p[:, 1] * MM, label=label, **look)


def plane(axes: Axes, title: str = "", adjustable: Literal["datalim", "box"] = "datalim") -> None:
    """Names of the task space's axes, both to the same scale; "box" for axes whose limits are given."""
    axes.set(title=title, xlabel="x [mm]", ylabel="y [mm]")
    axes.set_aspect("equal", adjustable=adjustable)


def key(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Legend above the drawing, where it hides no curve."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, handlelength=2.2, columnspacing=1.2)
