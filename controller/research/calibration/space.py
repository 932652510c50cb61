"""The box that is searched: points of the unit cube, and the plants and gains that they stand for."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import norm, qmc

from controller.arrays import Array
from controller.errors import ParameterError
from controller.research.calibration.unknowns import COSSERAT_UNKNOWNS, UNKNOWNS, Unknown
from controller.schema.fit import GAIN_NAMES
from controller.schema.modes import Integrator
from controller.schema.parameters import PlantKind, Settings, TwinParameters
from controller.simulation.case import Setup

DIGITS = 4
"""Significant digits of every decoded number: what the fit file says is exactly what was run."""


@dataclass(frozen=True)
class Space:
    """Unknowns, one coordinate of the cube each, on top of a setup that gives every other number."""

    unknowns: tuple[Unknown, ...] = UNKNOWNS
    base: Setup = field(default_factory=Setup)

    def values(self, z: Array) -> dict[str, float]:
        """The unknowns at z (n,) in [0, 1], by name, rounded to DIGITS. Raises ParameterError outside the cube."""
        if len(z) != len(self.unknowns) or not (np.isfinite(z).all() and (z >= 0.0).all() and (z <= 1.0).all()):
            raise ParameterError(f"z = {z} is not {len(self.unknowns)} numbers in [0, 1]")
        return {one.name: float(f"{one.value(share):.{DIGITS}g}") for one, share in zip(self.unknowns, z, strict=True)}

    def decode(self, z: Array) -> Setup:
        """Plant and gains at z (n,). Raises ParameterError as `values` does, or for an unknown that nothing has."""
        values = self.values(z)
        gains = {name: (values.pop(name),) * 2 for name in GAIN_NAMES if name in values}
        twin: dict[str, Any] = self.base.twin.model_dump()
        for name, value in values.items():
            place(twin, name, value)
        return Setup(
            TwinParameters.model_validate(twin),
            self.base.controller,
            Settings.model_validate(self.base.gains.model_dump() | gains),
        )

    def prior_residuals(self, z: Array) -> Array:
        """Standard deviations (n,) off each prior."""
        values = self.values(z)
        return np.array([one.surprise(values[one.name]) for one in self.unknowns])

    def prior_point(self) -> Array:
        """The priors themselves (n,)."""
        return np.array([one.share(one.prior) for one in self.unknowns])

    def draw(self, count: int, seed: int) -> Array:
        """Points (count, n): the priors, then a Sobol sequence spread as the priors are; no earlier fit."""
        shares = qmc.Sobol(len(self.unknowns), rng=seed).random_base2(max(1, count).bit_length())[: max(0, count - 1)]
        ends = [[one.surprise(one.low), one.surprise(one.high)] for one in self.unknowns]
        below, above = np.asarray(norm.cdf(ends)).T
        off = norm.ppf(below + shares * (above - below))
        return np.vstack([self.prior_point(), *([self.off_priors(row)] for row in off)])[:count]

    def off_priors(self, off: Array) -> Array:
        """The point (n,) that is `off` standard deviations (n,) off the priors."""
        values = (
            one.unscaled(one.scaled(one.prior) + d * one.spread) for one, d in zip(self.unknowns, off, strict=True)
        )
        return np.array([one.share(value) for one, value in zip(self.unknowns, values, strict=True)])


def space_of(plant: PlantKind) -> Space:
    """What is searched of this plant. The twin makes one implicit step a tick: twice as many fits in the same time."""
    unknowns = COSSERAT_UNKNOWNS if plant == "cosserat" else UNKNOWNS
    return Space(unknowns, Setup(twin=TwinParameters(plant=plant, integrator=Integrator.IMPLICIT)))


def place(fields: dict[str, Any], name: str, value: float) -> None:
    """Put `value` at `name` ("kappa", "creep.0") into `fields`. Raises ParameterError if there is no such place."""
    key, _, rest = name.partition(".")
    if isinstance(fields.get(key), dict):
        place(fields[key], rest, value)
        return
    entries: list[Any] = list(fields[key]) if rest and key in fields else []
    if key not in fields or (rest and int(rest) >= len(entries)):
        raise ParameterError(f"unknown = {name!r} is no field of the twin")
    if rest:
        entries[int(rest)] = value
    fields[key] = tuple(entries) if rest else value


def value_in(setup: Setup, name: str) -> float:
    """The number called `name` in `setup`."""
    if name in GAIN_NAMES:
        return float(getattr(setup.gains, name)[0])
    found: Any = setup.twin
    for part in name.split("."):
        found = found[int(part)] if part.isdecimal() else getattr(found, part)
    return float(found)
