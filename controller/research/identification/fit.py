"""What every identification hands back: numbers with confidence intervals, misfits, and what to plot."""

from dataclasses import dataclass, field
from typing import Literal

from controller.arrays import Array
from controller.schema.actuator import Actuator


@dataclass(frozen=True)
class Estimate:
    """One identified number with its 95 % confidence interval, in `unit` (SI, `1` where there is none)."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    note: str = ""


@dataclass(frozen=True)
class Misfit:
    """Root mean square of what the fitted model leaves unexplained, over `samples` measured values."""

    name: str
    rms: float
    unit: str
    samples: int


@dataclass(frozen=True)
class PlotSeries:
    """One curve or cloud of a plot: x, y (n,) in the units that the axes say."""

    label: str
    x: Array
    y: Array
    style: Literal["line", "points"] = "line"


@dataclass(frozen=True)
class Plot:
    """One panel of the report; the axis labels carry the units, as in "time [s]"."""

    title: str
    x_label: str
    y_label: str
    series: tuple[PlotSeries, ...]
    equal_axes: bool = False
    """One metre is as long on both axes: for shapes in the plane."""
    log_x: bool = False


@dataclass(frozen=True)
class Fit:
    """Result of one identification. `actuator` is the base actuator with every identified number put in."""

    title: str
    method: str
    """One or two sentences for the report: what was fitted to what, and how."""
    actuator: Actuator
    parameters: tuple[Estimate, ...]
    misfits: tuple[Misfit, ...] = ()
    plots: tuple[Plot, ...] = ()
    notes: tuple[str, ...] = field(default=())
    """Findings that a reader must know, one sentence each."""
