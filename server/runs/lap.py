"""One lap of a reference, and a leg: what the rig is given of it at once."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.link import ENDLESS
from controller.reference.feasible.bounds import Limits
from controller.reference.reference import row_kinds
from controller.schema.messages import RigInfo
from controller.schema.modes import RowKind
from controller.schema.parameters import RigParameters, Settings
from server.runs.messages import Learned, Learning


class Allowed(NamedTuple):
    """What the rows of a run are held within."""

    shape: Limits
    travel: Limits
    """Of approaches and ways back, which are ours."""
    dt: float
    """Period of the rows [s]."""


@dataclass(frozen=True)
class Lap:
    """A reference as a run follows it, over and over."""

    name: str
    lead: Array
    """Rows (m, 2) [m] before the first lap only, as where the tip waits for the first of some steps."""
    p: Array
    """Rows (n, 2) [m] of one lap; the first comes after the last."""
    back: int
    """This many rows at its end are a way back to its start, which is left out after the last lap."""
    u: Array
    """Torques (m + n, 2) [N m] that hold `lead` and `p`."""
    frequency: tuple[float, float] | None
    """[Hz] of x and y where the laps are periodic."""
    travel: np.ndarray
    """(n,) of bool: rows of `p` that only lead to another pose of the arm, or back to the start."""
    allowed: Allowed
    kind: RowKind
    """Of the shape's rows."""
    steps: tuple[int, ...] = ()
    """Rows of `p` at which a declared step begins."""

    def rows(self, laps: int | None) -> int:
        """How many rows this number of laps has; None: without end."""
        return ENDLESS if laps is None else laps * len(self.p) - self.back

    @property
    def torques(self) -> Array:
        """(n, 2) [N m] of `p`."""
        return self.u[len(self.lead) :]


def velocity_gain(kind: RowKind, rig: RigParameters, settings: Settings, own_gains: bool) -> tuple[float, float]:
    """K_FF [s] with which rows of `kind` are followed, in x and y: the kernel's `choose_velocity_gain`.

    None by a controller that has gains of its own.
    """
    if own_gains:
        return 0.0, 0.0
    own = kind == RowKind.FED and settings.K_FF == (0.0, 0.0)
    return (rig.controller.reference_K_FF,) * 2 if own else settings.K_FF


def in_slot(rig: RigInfo, settings: Settings) -> tuple[str, bool]:
    """Name of the controller that these settings choose, and whether it has gains of its own; "" without a slot."""
    chosen = rig.controllers[settings.controller] if rig.controllers else None
    return ("", False) if chosen is None else (chosen.name, chosen.own_gains)


@dataclass(frozen=True)
class Leg:
    """What the rig is given for one stretch of a run: from its start, or from a pause, on."""

    p: Array
    """Rows (n, 2) [m]."""
    u: Array
    """Torques (n, 2) [N m] that hold them."""
    travel: np.ndarray
    """(n,) of bool: rows that are not judged."""
    again: int
    """Row that comes after the last one: the first of the shape."""
    done: int
    """Rows of the shape that were followed in earlier legs."""
    ticks: int
    """Rows to follow in all."""
    kind: RowKind
    """Of the rows that are judged."""
    steps: bool = False
    """It declares that it steps."""
    planned: Array | None = None
    """Torques (n, 2) [N m] that move the model along the rows, where the controller follows such."""
    planned_again: Array | None = None
    """The same (n - again, 2) of every lap but the first."""
    learned: Learned | None = None
    """What those are learned from."""

    @property
    def kinds(self) -> np.ndarray:
        """RowKind (n,) of uint8."""
        return row_kinds(self.travel, self.kind)

    def row(self, index: np.ndarray) -> np.ndarray:
        """Rows of `p` that come at `index` (k,), counted from the leg's first tick."""
        repeating = self.again + (index - self.again) % (len(self.p) - self.again)
        return np.where(index < len(self.p), index, repeating)

    def planned_at(self, index: np.ndarray) -> Array | None:
        """The planned torques at those ticks (k, 2) [N m]; None without any."""
        if self.planned is None:
            return None
        first: Array = self.planned[self.row(index)]
        later = index >= len(self.p)
        if self.planned_again is not None:
            first[later] = self.planned_again[self.row(index[later]) - self.again]
        return first

    def at(self, index: np.ndarray) -> Array:
        """Where the reference is at the ticks `index` (k,) counted from the leg's first: (k, 2) [m]."""
        found: Array = self.p[self.row(index)]
        return found


class Order(NamedTuple):
    """What all legs of a run share."""

    lap: Lap
    laps: int | None
    rig: RigParameters
    settings: Settings
    learning: Learning


@dataclass(frozen=True)
class Place:
    """Where a run was left."""

    done: int
    """Rows of the shape that were followed."""
    u: Array
    """Feedforward torques (2,) [N m] there."""
