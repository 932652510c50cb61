"""A planned reference on its way to the rig: what is sent, and its bytes."""

from typing import NamedTuple

import numpy as np

from controller.errors import ParameterError
from controller.schema.parameters import REFERENCE_ROWS

HEAD, POINT, TORQUES, KIND = 32, 16, 8, 1
"""Bytes of the four words, of a point, of its torques (float32: the rig refines them) and of its kind."""
PLANNED_MAX = HEAD + (POINT + 3 * TORQUES + KIND) * REFERENCE_ROWS
"""Longest message [bytes]."""


class PlannedRows(NamedTuple):
    """What a TRACK run follows."""

    points: np.ndarray
    """(n, 2) [m], one a tick."""
    torques: np.ndarray | None = None
    """(n, 2) [N m] that hold the points; without them the rig stays in the pose of the arm in which it is."""
    kinds: np.ndarray | None = None
    """(n,) of uint8, RowKind; all are DRAWN without it."""
    again: int = 0
    """Point that comes after the last one."""
    ticks: int | None = None
    """Points to follow in all; each once where None."""
    planned: np.ndarray | None = None
    """(n, 2) [N m] torques that move the model along the points, for a controller that follows such."""
    planned_again: np.ndarray | None = None
    """(n - again, 2) the same of every further time that the points from `again` on are followed."""
    steps: bool = False
    """It declares that it steps: the rig then has no bounds on its speed, acceleration and torque rate."""


def encoded(rows: PlannedRows) -> bytes:
    """int64 (again, ticks, steps, what follows), float64 (n, 2) points, float32 (n, 2) torques, those planned, those
    planned for further times, uint8 (n,) kinds.

    What follows the points: the sum of 1 for torques, 2 for kinds, 4 for planned torques, 8 for those of further times.
    """
    ticks = len(rows.points) if rows.ticks is None else rows.ticks
    optional = (rows.torques, rows.kinds, rows.planned, rows.planned_again)
    words = np.array([rows.again, ticks, rows.steps, sum((one is not None) << n for n, one in enumerate(optional))])
    floats = [(one, np.float32) for one in (rows.torques, rows.planned, rows.planned_again)]
    parts = [(words, np.int64), (rows.points, np.float64), *floats, (rows.kinds, np.uint8)]
    return b"".join(np.ascontiguousarray(part, kind).tobytes() for part, kind in parts if part is not None)


def decoded(payload: bytes) -> PlannedRows:
    """What `encoded` gives; ParameterError for a payload that it cannot have given."""
    words = np.frombuffer(payload[:HEAD], np.int64).tolist() if len(payload) >= HEAD else [0, 0, 0, -1]
    again, ticks, steps, more = words
    torqued, told, planned, further = (bool(more & bit) for bit in (1, 2, 4, 8))
    row = POINT + KIND * told + TORQUES * (torqued + planned + further)
    rest = len(payload) - HEAD + TORQUES * again * further
    if more not in range(16) or rest % row or not 0 <= again <= rest // row:
        raise ParameterError(f"reference of {len(payload)} bytes is not four int64 words and rows of {row} bytes")
    count, at = rest // row, HEAD
    points, at = np.frombuffer(payload, count=2 * count, offset=at).reshape(-1, 2), at + POINT * count
    torques, at = _torques(payload, at, count * torqued)
    ahead, at = _torques(payload, at, count * planned)
    later, at = _torques(payload, at, (count - again) * further)
    kinds = np.frombuffer(payload, np.uint8, offset=at) if told else None
    return PlannedRows(points, torques, kinds, again, ticks, ahead, later, bool(steps))


def _torques(payload: bytes, at: int, count: int) -> tuple[np.ndarray | None, int]:
    """Torques (count, 2) [N m] from the byte `at` on, None for none, and where the rest begins."""
    if not count:
        return None, at
    found = np.frombuffer(payload, np.float32, 2 * count, at).astype(np.float64).reshape(-1, 2)
    return found, at + TORQUES * count
