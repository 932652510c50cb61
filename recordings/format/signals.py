"""How a Telemetry row is spread over rerun entities: few entities with many series each, since every entity costs.

Values are Telemetry's own numbers in SI units, bit for bit (integers below 2^53 are exact as float64).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from controller.arrays import Array32, Values
from controller.schema.display import shown
from controller.schema.layout import quantity
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from controller.schema.palette import DANGER, LINES, MEASURED, OBSERVER, REFERENCE, TWIN, pale
from controller.schema.slot import SIGNALS
from controller.schema.titles import title

TARGET = pale(REFERENCE, 0.4)
FIRST, SECOND = LINES[:2]
"""Two components."""
CHAMBERS = LINES[:4]

MODE_COLORS = {
    Mode.VENTED: TWIN,
    Mode.HOLD: OBSERVER,
    Mode.FOLLOW: MEASURED,
    Mode.TRACK: MEASURED,
    Mode.REST: LINES[1],
    Mode.FAULT: REFERENCE,
    Mode.E_STOP: DANGER,
}


def rgba(colors: Iterable[int]) -> np.ndarray[Any, np.dtype[np.uint32]]:
    """Opaque 0xRRGGBBAA from 0xRRGGBB."""
    return np.array([color << 8 | 0xFF for color in colors], np.uint32)


@dataclass(frozen=True)
class Series:
    """One line of a plot: an element of a telemetry field (`index` None: the field is one number)."""

    field: str
    index: int | None
    color: int
    width: float = 1.5

    @property
    def label(self) -> str:
        """Its name on the page and in exports."""
        return title(self.field, self.index)

    @property
    def name(self) -> str:
        """Label with the unit, as the legend shows it."""
        return self._with(quantity(Telemetry, self.field).unit)

    @property
    def shown(self) -> tuple[str, float]:
        """Name with the unit in which people read it, and the factor to that from SI."""
        unit, scale = shown(quantity(Telemetry, self.field).unit)
        return self._with(unit), scale

    def _with(self, unit: str) -> str:
        return self.label if unit == "1" else f"{self.label} [{unit}]"


@dataclass(frozen=True)
class Group:
    """The series of one rerun entity, written at every tick."""

    path: str
    series: tuple[Series, ...]


def _each(field: str, colors: tuple[int, ...], width: float = 1.5) -> Iterator[Series]:
    """One series per element of a vector field."""
    for index, color in enumerate(colors):
        yield Series(field, index, color, width)


def _shades(share: float) -> tuple[int, int]:
    return pale(FIRST, share), pale(SECOND, share)


def _tip(axis: int) -> tuple[Series, ...]:
    return (
        Series("target", axis, TARGET, 1.0),
        Series("p_ref", axis, REFERENCE, 2.0),
        Series("p_meas", axis, MEASURED),
        Series("p_hat", axis, OBSERVER),
    )


GROUPS = (
    Group("/tip/x", _tip(0)),
    Group("/tip/y", _tip(1)),
    Group(
        "/error",
        (
            Series("error", 0, FIRST),
            Series("error", 1, SECOND),
            Series("residual", None, OBSERVER),
        ),
    ),
    Group(
        "/pressures",
        (
            *_each("pressure_cmd", CHAMBERS, 1.0),
            *_each("pressure_meas", CHAMBERS, 2.0),
        ),
    ),
    Group(
        "/u",
        (
            *_each("u", (FIRST, SECOND), 2.5),
            *_each("u_ff", _shades(0.35), 1.0),
            *_each("u_fb", _shades(0.6), 1.0),
            *_each("u_hat", (OBSERVER, TWIN), 1.0),
        ),
    ),
    Group(
        "/observer",
        (
            Series("energy", None, OBSERVER, 2.0),
            Series("ledger", None, DANGER),
            Series("power", 0, TWIN, 1.0),
            Series("power", 1, REFERENCE, 1.0),
            Series("power", 2, MEASURED, 1.0),
            Series("power", 3, LINES[4], 1.0),
        ),
    ),
    Group(
        "/timing",
        (Series("lateness_ns", None, REFERENCE), Series("step_ns", None, OBSERVER)),
    ),
    Group(
        "/state",
        (
            Series("slot", None, TWIN),
            Series("lost", None, DANGER),
            Series("mode", None, OBSERVER),
            Series("cause", None, TWIN),
            Series("command_n", None, REFERENCE),
            Series("request_n", None, REFERENCE),
            Series("request_cause", None, DANGER),
            Series("presence", None, MEASURED),
            Series("law", None, LINES[3]),
            Series("sensed", None, MEASURED),
            Series("saturated", None, DANGER),
            Series("reachable", None, MEASURED),
            Series("measurement_age", None, MEASURED),
            Series("operator_age", None, OBSERVER),
            Series("server_age", None, TWIN),
            *_each("p_ref_dot", (FIRST, SECOND)),
            *_each("integral", (FIRST, SECOND)),
            Series("reseats", None, OBSERVER),
            Series("controller", None, LINES[3]),
            *_each("signals", (LINES * SIGNALS)[:SIGNALS], 1.0),
        ),
    ),
)
"""Everything that is written at every tick beside the timelines `t` (from t_ns), `tick` and `time`.

What a later version adds comes last in the last group, so the columns of older recordings keep their places.
"""

MARKERS = "/markers"
"""Entity with the markers [m] as they were measured, written whenever they change."""

APPROACH = "/approach"
"""Entity with the first tick and the end of every stretch that leads into a run."""

BOOKMARKS = "/bookmarks"
"""Entity with a line of text at each place that was marked: its number, and its label if it had one then."""

PLAN_PERIOD = 10
"""Backbones and points of the plan view are written at every tick that this number divides: 100 Hz."""

OBSERVER_BACKBONE, TWIN_BACKBONE = "/plan/observer", "/plan/twin"
BACKBONES = {OBSERVER_BACKBONE: "backbone", TWIN_BACKBONE: "twin_backbone"}
"""Entities of the plan view that hold a whole telemetry field each."""


def flip(points: Values) -> Array32:
    """Plane frame (y up) to that of rerun's 2-D views (y down), and back: (..., 2). y is negated nowhere else."""
    return np.asarray(points * (1.0, -1.0), np.float32)
