"""A planned path of the tip, sampled for the loop."""

from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.schema.modes import RowKind


@dataclass(frozen=True)
class Reference:
    """Where the tip is wanted at every tick (dt = 1 ms unless the controller says otherwise), approach included."""

    name: str
    """One of the library's names, or a file's."""
    p: Array
    """(n, 2) [m], one row a tick."""
    start: int
    """Ticks of the approach from rest: row `start` is the first point of the shape."""
    steps: tuple[int, ...] = ()
    """Ticks at which a step begins (diamond)."""
    frequency: float | None = None
    """[Hz], of a periodic shape."""
    velocity_feedforward: bool = False
    """Whether K_FF is on after the approach: in all of Task 2 and for the circles of Task 3."""
    led: int = 0
    """Ticks of the approach from rest to where the path itself begins; it may wait or approach until `start`."""
    u: Array | None = None
    """(n, 2) torques [N m] that hold the points, where they are known."""
    travel: np.ndarray | None = None
    """(n,) of bool: rows that only lead to another pose of the arm, and are not judged; None: no row after `start`."""
    known: bool = False
    """Whether the arm is known to follow it, as it is for the library's own."""
    asked: Array | None = None
    """(n, 2) [m] what the torques are planned for, where that is learned (`learning.py`) and not `p` itself."""
    axis_frequencies: tuple[float, float] | None = None
    """[Hz] at which x and y swing, where that is not `frequency` for both, as in a Lissajous figure."""

    @property
    def kinds(self) -> np.ndarray:
        """RowKind (n,) of uint8. The velocity feedforward comes after the approach."""
        found = row_kinds(np.zeros(len(self.p), bool) if self.travel is None else self.travel, self.kind)
        led = found[: self.start]
        led[led == RowKind.FED] = RowKind.KNOWN
        return found

    @property
    def kind(self) -> RowKind:
        """Of the rows that lead nowhere else."""
        if not self.known:
            return RowKind.DRAWN
        return RowKind.FED if self.velocity_feedforward else RowKind.KNOWN


def row_kinds(travel: np.ndarray, kind: RowKind) -> np.ndarray:
    """RowKind (n,) of uint8 of rows that are `travel` (n,) of bool, or of `kind`."""
    return np.where(travel, RowKind.TRAVEL, kind).astype(np.uint8)
