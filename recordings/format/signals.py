"""How a Telemetry row is spread over rerun entities: few entities with many series each, since every entity costs.

Values are Telemetry's own numbers in SI units, bit for bit (integers below 2^53 are exact as float64).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from controller.schema.layout import quantity
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode

REFERENCE, MEASURED, OBSERVER, TWIN, GHOST, DANGER = 0xE69F00, 0x009E73, 0x56B4E9, 0x999999, 0xCC79A7, 0xD55E00
"""One colour per role, as on the page."""

YELLOW, BLUE, PINK, SILVER = 0xF0E442, 0x0072B2, 0xCC79A7, 0xBBBBBB
"""Colours for what has no role (components, chambers, powers); colour-blind safe beside the roles."""

PAIRS = {"": (0x0072B2, 0xCC79A7), "feedforward": (0x66AAD7, 0xE0A9C8), "feedback": (0xA6D0EE, 0xF0D3E2)}
"""The two components of u in three shades each."""

MODE_COLORS = {
    Mode.VENTED: TWIN,
    Mode.HOLD: OBSERVER,
    Mode.FOLLOW: MEASURED,
    Mode.TRACK: MEASURED,
    Mode.REST: YELLOW,
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
    label: str
    color: int
    width: float = 1.5

    @property
    def name(self) -> str:
        """Label with the unit, as the legend shows it."""
        unit = quantity(Telemetry, self.field).unit
        return self.label if unit == "1" else f"{self.label} [{unit}]"


@dataclass(frozen=True)
class Group:
    """The series of one rerun entity, written at every tick."""

    path: str
    series: tuple[Series, ...]


def _each(field: str, label: str, colors: tuple[int, ...], width: float = 1.5) -> Iterator[Series]:
    """One series per element of a vector field; `{}` in the label is its number."""
    for index, color in enumerate(colors):
        yield Series(field, index, label.format(index + 1), color, width)


def _tip(axis: int) -> tuple[Series, ...]:
    name = "xy"[axis]
    return (
        Series("target", axis, f"target {name}", YELLOW, 1.0),
        Series("p_ref", axis, f"reference {name}", REFERENCE, 2.0),
        Series("p_meas", axis, f"measured {name}", MEASURED),
        Series("p_hat", axis, f"observer {name}", OBSERVER),
    )


GROUPS = (
    Group("/tip/x", _tip(0)),
    Group("/tip/y", _tip(1)),
    Group(
        "/error",
        (
            Series("error", 0, "error x", YELLOW),
            Series("error", 1, "error y", PINK),
            Series("residual", None, "observer residual", OBSERVER),
        ),
    ),
    Group(
        "/pressures",
        (
            *_each("pressure_cmd", "chamber {} wanted", (BLUE, YELLOW, PINK, SILVER), 1.0),
            *_each("pressure_meas", "chamber {} measured", (BLUE, YELLOW, PINK, SILVER), 2.0),
        ),
    ),
    Group(
        "/u",
        (
            *_each("u", "u{} sent", PAIRS[""], 2.5),
            *_each("u_ff", "u{} feedforward", PAIRS["feedforward"], 1.0),
            *_each("u_fb", "u{} feedback", PAIRS["feedback"], 1.0),
            *_each("u_hat", "u{} in the observer", (OBSERVER, TWIN), 1.0),
        ),
    ),
    Group(
        "/observer",
        (
            Series("energy", None, "energy", OBSERVER, 2.0),
            Series("ledger", None, "ledger", DANGER),
            Series("power", 0, "damping power", TWIN, 1.0),
            Series("power", 1, "pneumatic power", REFERENCE, 1.0),
            Series("power", 2, "observer power", MEASURED, 1.0),
            Series("power", 3, "Baumgarte power", PINK, 1.0),
        ),
    ),
    Group(
        "/timing",
        (Series("lateness_ns", None, "lateness", REFERENCE), Series("step_ns", None, "tick duration", OBSERVER)),
    ),
    Group(
        "/state",
        (
            Series("slot", None, "slot", TWIN),
            Series("lost", None, "slots lost", DANGER),
            Series("mode", None, "mode", OBSERVER),
            Series("cause", None, "cause", TWIN),
            Series("command_n", None, "command in force", REFERENCE),
            Series("request_n", None, "request", REFERENCE),
            Series("request_cause", None, "refusal", DANGER),
            Series("presence", None, "presence", MEASURED),
            Series("law", None, "law", BLUE),
            Series("sensed", None, "sensed rods", MEASURED),
            Series("saturated", None, "saturated", DANGER),
            Series("reachable", None, "reachable", MEASURED),
            Series("measurement_age", None, "measurement age", MEASURED),
            Series("operator_age", None, "operator age", OBSERVER),
            Series("server_age", None, "server age", TWIN),
            *_each("p_ref_dot", "reference velocity {}", (REFERENCE, YELLOW)),
            *_each("integral", "integral {}", (BLUE, PINK)),
        ),
    ),
)
"""Everything that is written at every tick beside the timelines `t` (from t_ns), `tick` and `time`."""

MARKERS = "/markers"
"""Entity with the markers [m] as they were measured, written whenever they change."""

APPROACH = "/approach"
"""Entity with the first tick and the end of every stretch that leads into a run."""

BOOKMARKS = "/bookmarks"
"""Entity with a line of text at each place that was marked: its number, and its label if it had one then."""

PLAN_PERIOD = 10
"""Backbones and points of the plan view are written at every tick that this number divides: 100 Hz."""
