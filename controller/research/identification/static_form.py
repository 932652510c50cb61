"""What a fit to static poses may change of an actuator: stiffness, what pressure adds to it, and the chambers' reach.

Two forms: the base's own, by its table or by its EI, and for a base by its table a continuous one, a backbone of EI
that begins at the clamp and chambers that meet at any arc length, where at the table's joints they cannot.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from controller.arrays import Array
from controller.research.identification.fit import Estimate
from controller.research.identification.regression import Solution, exponential, plain
from controller.schema.actuator import Actuator
from controller.schema.rigidity import joint_stiffness

Shape = Literal["uniform", "linear", "scaled"]
"""Profile of the stiffness: one value, two ends of a line, or the base actuator's own profile times one factor."""

SHAPES: tuple[Shape, ...] = get_args(Shape)
STIFFER_LEAST = -0.9
"""What pressure adds to a stiffness is more than this share of it, whatever a solver tries."""
MEETING = (0.05, 0.95)
"""The chambers meet between these shares of the length."""


@dataclass(frozen=True)
class StaticForm:
    """What is unknown; the unknowns are ln of the stiffness, then what full pressure adds, then where chambers meet."""

    base: Actuator
    shape: Shape
    level: tuple[float, float]
    """Largest sum of each pair's pressures in the data [Pa]."""
    stiffens: bool = False
    continuous: bool = False
    """Whether EI and arc lengths take the place of the table's k and chambers."""

    @property
    def by_rigidity(self) -> bool:
        """Whether it is EI that is fitted."""
        return self.continuous or self.base.EI is not None

    @property
    def profile(self) -> tuple[float, ...]:
        """The base's stiffness, in the form that is fitted."""
        if self.base.EI is not None:
            return self.base.EI
        cell = self.base.length / self.base.table_rods if self.continuous else 1.0
        return tuple(cell * value for value in self.base.k)

    @property
    def sizes(self) -> tuple[int, int, int]:
        """How many unknowns there are of each kind."""
        return 2 if self.shape == "linear" else 1, 2 * self.stiffens, int(self.continuous)

    def start(self, factor: float) -> Array:
        """Unknowns of the base with its stiffness times `factor`."""
        own = self.profile
        values = {"uniform": [np.mean(own)], "linear": [own[0], own[-1]], "scaled": [1.0]}[self.shape]
        stiffness = np.log(factor * np.array(values))
        meeting = self.base.chambers[0][1] / self.base.table_rods
        return np.concatenate([stiffness, np.zeros(self.sizes[1]), np.full(self.sizes[2], meeting)])

    def start_from(self, other: "StaticForm", x: Array) -> Array:
        """Unknowns with the stiffness that the unknowns x of another form of the same base mean."""
        begin = self.start(1.0)
        begin[: self.sizes[0]] += x[: self.sizes[0]] - other.start(1.0)[: self.sizes[0]]
        return begin

    def actuator(self, x: Array) -> Actuator:
        """The base with the unknowns x (p,) put in, which may be out of bounds."""
        return self.base.model_copy(update=self._changes(x))

    def is_possible(self, x: Array) -> bool:
        """Whether pressure stiffens the body, and does not soften it."""
        return min(self.actuator(x).stiffening) >= 0.0

    def estimates(self, solution: Solution) -> tuple[Estimate, ...]:
        """The unknowns by name, with their intervals."""
        found = [self._stiffness(solution, i) for i in range(self.sizes[0])]
        rows = np.eye(solution.x.size)
        if self.shape == "linear":
            found.append(exponential("taper, tip / base", "1", solution, rows[1] - rows[0]))
        for j in range(self.sizes[1]):
            row = rows[self.sizes[0] + j] / self.level[j]
            found.append(plain(f"stiffening of pair {j + 1}", "1/Pa", solution, row))
        if self.continuous:
            found.append(plain("chambers meet at", "m", solution, self.base.length * rows[-1]))
        return tuple(found)

    def _stiffness(self, solution: Solution, i: int) -> Estimate:
        name, unit = ("EI", "N m^2") if self.by_rigidity else ("k", "N m/rad")
        if self.shape == "scaled":
            name, unit = f"{name} / {name} of the base file", "1"
        elif self.shape == "linear":
            name += ", base" if i == 0 else ", tip"
            name += "" if self.by_rigidity else " joint"
        return exponential(name, unit, solution, np.eye(solution.x.size)[i])

    def _changes(self, x: Array) -> dict[str, object]:
        stiffness, added, meeting = np.split(x, np.cumsum(self.sizes)[:2])
        values = tuple(np.exp(stiffness).tolist())
        if self.shape == "scaled":
            values = tuple(values[0] * own for own in self.profile)
        changes: dict[str, object] = self._by_rigidity(values) if self.by_rigidity else {"k": values}
        if self.stiffens:
            shares = np.maximum(added, STIFFER_LEAST) / np.array(self.level)
            changes["stiffening"] = tuple(shares.tolist())
        if self.continuous:
            s = float(np.clip(meeting[0], *MEETING)) * self.base.length
            changes["chamber_arcs"] = ((0.0, s), (s, self.base.length))
        return changes

    def _by_rigidity(self, EI: tuple[float, ...]) -> dict[str, object]:
        """EI [N m^2] and what follows from it, as in a file that was read."""
        base = self.base
        beta = base.beta if base.beta is not None else float(np.mean(base.b) / np.mean(base.k))
        arc = base.EI_arc if self.shape == "scaled" else ()
        k = joint_stiffness(EI, arc, base.length, base.table_rods)
        return {"EI": EI, "EI_arc": arc, "beta": beta, "k": tuple(k.tolist()), "b": tuple((beta * k).tolist())}
