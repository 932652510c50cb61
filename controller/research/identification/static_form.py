"""What a fit to static poses may change of an actuator: stiffness, what pressure adds to it and to the length, gains.

Two forms of the body: the base's own, by its table or by its EI, and for a base by its table a continuous one, a
backbone of EI that begins at the clamp and chambers that meet at any arc length, where at the table's joints they
cannot.
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
ADDED_LEAST = -0.9
"""What pressure adds to a stiffness or a length is more than this share of it, also in what a fit tries."""
RATIOS = ("u1- over u1+", "u2- over u2+", "pair 2 over pair 1")
MEANT = 0.5 * np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, -1.0, 1.0], [0.0, 1.0, 1.0]])
"""Of ln of these ratios, in ln of the chambers' pressures per torque, whose product stays: it is in the stiffness."""
MEETING = (0.05, 0.95)
"""The chambers meet between these shares of the length."""


@dataclass(frozen=True)
class StaticForm:
    """What is unknown: ln of the stiffness, what full pressure adds to it and to the length, gains, the meeting place.

    Poses tell torque over stiffness alone, so of four gains only their ratios; where the stiffness has a taper, which
    a ratio of the pairs would do much like, only those within the pairs.
    """

    base: Actuator
    shape: Shape
    level: tuple[float, float]
    """Largest sum of each pair's pressures in the data [Pa]."""
    stiffens: bool = False
    stretches: bool = False
    uneven: bool = False
    """Whether the chambers' gains are not those of the base."""
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
    def sizes(self) -> tuple[int, int, int, int, int]:
        """How many unknowns there are of each kind."""
        linear = self.shape == "linear"
        gains = (2 if linear else 3) * self.uneven
        return 2 if linear else 1, 2 * self.stiffens, 2 * self.stretches, gains, int(self.continuous)

    def start(self, factor: float) -> Array:
        """Unknowns of the base with its stiffness times `factor`."""
        own = self.profile
        values = {"uniform": [np.mean(own)], "linear": [own[0], own[-1]], "scaled": [1.0]}[self.shape]
        stiffness = np.log(factor * np.array(values))
        meeting = self.base.chambers[0][1] / self.base.table_rods
        return np.concatenate([stiffness, np.zeros(sum(self.sizes[1:4])), np.full(self.sizes[4], meeting)])

    def start_from(self, other: "StaticForm", x: Array) -> Array:
        """Unknowns that mean the same as the unknowns x of another form of the same base, with fewer of them."""
        begin = self.start(1.0)
        kinds = np.split(begin, np.cumsum(self.sizes)[:-1])
        for kind, moved in zip(kinds, np.split(x - other.start(1.0), np.cumsum(other.sizes)[:-1]), strict=True):
            kind[: moved.size] += moved
        return begin

    def actuator(self, x: Array) -> Actuator:
        """The base with the unknowns x (p,) put in, which may be out of bounds."""
        return self.base.model_copy(update=self._changes(x))

    def is_possible(self, x: Array) -> bool:
        """Whether pressure stiffens and lengthens the body, and does neither the other way."""
        found = self.actuator(x)
        return min(*found.stiffening, *found.stretching) >= 0.0

    def estimates(self, solution: Solution) -> tuple[Estimate, ...]:
        """The unknowns by name, with their intervals."""
        found = [self._stiffness(solution, i) for i in range(self.sizes[0])]
        rows = np.eye(solution.x.size)
        if self.shape == "linear":
            found.append(exponential("taper, tip / base", "1", solution, rows[1] - rows[0]))
        at = np.cumsum(self.sizes)
        for kind, name in enumerate(("stiffening", "stretching")):
            for j in range(self.sizes[1 + kind]):
                row = rows[at[kind] + j] / self.level[j]
                found.append(plain(f"{name} of pair {j + 1}", "1/Pa", solution, row))
        for j in range(self.sizes[3]):
            found.append(exponential(f"pressure for the same torque, {RATIOS[j]}", "1", solution, rows[at[2] + j]))
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
        stiffness, stiffer, longer, gains, meeting = np.split(x, np.cumsum(self.sizes)[:4])
        values = tuple(np.exp(stiffness).tolist())
        if self.shape == "scaled":
            values = tuple(values[0] * own for own in self.profile)
        changes: dict[str, object] = self._by_rigidity(values) if self.by_rigidity else {"k": values}
        for name, added in (("stiffening", stiffer), ("stretching", longer)):
            if added.size:
                shares = np.maximum(added, ADDED_LEAST) / np.array(self.level)
                changes[name] = tuple(shares.tolist())
        if self.uneven:
            changes["pressure_map"] = tuple(
                (self.base.chamber_slopes * np.exp(MEANT[:, : gains.size] @ gains)).tolist()
            )
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
