"""A planned reference on its way to the rig: what is sent, and its bytes."""

from typing import NamedTuple

import numpy as np

from controller.errors import ParameterError
from controller.schema.parameters import REFERENCE_ROWS

HEAD, POINT, TORQUES, KIND = 32, 16, 8, 1
"""Bytes of the four words, of a point, of its torques (float32: the rig refines them) and of its kind."""
PLANNED_MAX = HEAD + (POINT + TORQUES + KIND) * REFERENCE_ROWS
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
    steps: bool = False
    """It declares that it steps: the rig then has no bounds on its speed, acceleration and torque rate."""


def encoded(rows: PlannedRows) -> bytes:
    """int64 (again, ticks, steps, what follows), float64 (n, 2) points, float32 (n, 2) torques, uint8 (n,) kinds.

    What follows the points: 1 for torques, 2 for kinds, 3 for both.
    """
    ticks = len(rows.points) if rows.ticks is None else rows.ticks
    more = (rows.torques is not None) + 2 * (rows.kinds is not None)
    words = np.array([rows.again, ticks, rows.steps, more], np.int64)
    parts = [(words, np.int64), (rows.points, np.float64), (rows.torques, np.float32), (rows.kinds, np.uint8)]
    return b"".join(np.ascontiguousarray(part, kind).tobytes() for part, kind in parts if part is not None)


def decoded(payload: bytes) -> PlannedRows:
    """What `encoded` gives; ParameterError for a payload that it cannot have given."""
    words = np.frombuffer(payload[:HEAD], np.int64).tolist() if len(payload) >= HEAD else []
    torqued, told = (words[3] & 1, words[3] & 2) if words else (0, 0)
    row = POINT + (TORQUES if torqued else 0) + (KIND if told else 0)
    if not words or words[3] not in range(4) or (len(payload) - HEAD) % row:
        raise ParameterError(f"reference of {len(payload)} bytes is not four int64 words and rows of {row} bytes")
    count = (len(payload) - HEAD) // row
    points = np.frombuffer(payload, count=2 * count, offset=HEAD).reshape(-1, 2)
    torques = kinds = None
    if torqued:
        torques = np.frombuffer(payload, np.float32, 2 * count, HEAD + POINT * count).astype(np.float64).reshape(-1, 2)
    if told:
        kinds = np.frombuffer(payload, np.uint8, offset=len(payload) - KIND * count)
    return PlannedRows(points, torques, kinds, words[0], words[1], bool(words[2]))
