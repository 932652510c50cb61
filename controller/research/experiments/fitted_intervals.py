"""The fit with which the paper's experiments are run, and the intervals that its near-equal fits give the paper's rows.

It is a file of its own: what a rig is driven with by hand is that of controller/schema/fit.toml (docs/reproduction.md).
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from controller.research.experiments.results import ResultRow
from controller.schema.parameters import PlantKind, Settings, TwinParameters
from controller.simulation.case import Setup

Key = tuple[str, str, str, str]
Interval = tuple[float, float]
PAPER_FIT: dict[str, Any] = tomllib.loads((Path(__file__).parents[1] / "paper_fit.toml").read_text("utf-8"))
"""As `tendril calibrate` wrote it."""


def paper_setup(plant: PlantKind = "rod") -> Setup:
    """Plant and gains of PAPER_FIT; of another plant than its own the numbers that both have."""
    gains = {name: (value,) * 2 for name, value in PAPER_FIT["gains"].items()}
    return Setup(TwinParameters(plant=plant, **PAPER_FIT["twin"]), gains=Settings(**gains))


def with_intervals(rows: Sequence[ResultRow], setup: Setup, fit: Mapping[str, Any]) -> tuple[ResultRow, ...]:
    """`rows`, each with its interval where the file has one and `setup` is the plant and the gains of that fit."""
    found = intervals_of(fit) if is_fitted(setup, fit) else {}
    return tuple(replace(row, interval=found.get(row.about.key)) for row in rows)


def intervals_of(fit: Mapping[str, Any]) -> dict[Key, Interval]:
    """Interval by row; empty before there are any."""
    return {
        (one["experiment"], one["actuator"], one["law"], one["metric"]): (one["low"], one["high"])
        for one in fit.get("spread", ())
    }


def is_fitted(setup: Setup, fit: Mapping[str, Any]) -> bool:
    """Whether `setup` has every number that was fitted, on the plant that it was fitted on."""
    twin = setup.twin
    numbers = ((getattr(twin, name), value) for name, value in fit["twin"].items())
    gains = ((getattr(setup.gains, name), [value] * 2) for name, value in fit["gains"].items())
    same = all(as_list(ours) == as_list(theirs) for ours, theirs in (*numbers, *gains))
    return twin.plant == "rod" and same


def as_list(value: Any) -> Any:
    """A tuple as a list: as the file has it."""
    return list(value) if isinstance(value, tuple) else value
