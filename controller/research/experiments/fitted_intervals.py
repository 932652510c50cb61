"""The fits with which the paper's experiments are run, and the intervals that near-equal fits give the paper's rows.

What a rig is driven with by hand is another one, controller/schema/fit.toml (docs/reproduction.md).
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from controller.research.experiments.results import ResultRow
from controller.schema.parameters import PlantKind, TwinParameters
from controller.simulation.case import FITTED_GAINS, Setup

Key = tuple[str, str, str, str]
Interval = tuple[float, float]
_FILES: dict[PlantKind, str] = {"rod": "paper_fit.toml", "cosserat": "cosserat_fit.toml"}


@cache
def paper_fit(plant: PlantKind) -> Mapping[str, Any]:
    """The fit of `plant` to the paper's rows, as `tendril calibrate` wrote it."""
    return tomllib.loads((Path(__file__).parents[1] / _FILES[plant]).read_text("utf-8"))


def paper_setup(plant: PlantKind = "rod") -> Setup:
    """Plant and gains of `paper_fit`."""
    fit = paper_fit(plant)
    gains = {name: (value,) * 2 for name, value in fit["gains"].items()}
    return Setup(TwinParameters(**fit["twin"]), gains=FITTED_GAINS.model_copy(update=gains))


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
    fitted = TwinParameters(**fit["twin"])  # what an older file leaves out is what it was fitted with
    numbers = all(getattr(setup.twin, name) == getattr(fitted, name) for name in {"plant", *fit["twin"]})
    return numbers and all(getattr(setup.gains, name) == (value,) * 2 for name, value in fit["gains"].items())
