"""A planned reference on its way to the rig: what is sent, and its bytes."""

from typing import NamedTuple

import numpy as np

from controller.build_rig import REFERENCE_ROWS
from controller.errors import ParameterError

HEAD, POINT, TORQUES = 32, 16, 8
"""Bytes of the four words, of a point and of its torques, which are float32: the rig refines them."""
PLANNED_MAX = HEAD + (POINT + TORQUES) * REFERENCE_ROWS
"""Longest message [bytes]."""


class PlannedRows(NamedTuple):
    """What a TRACK run follows."""

    points: np.ndarray
    """(n, 2) [m], one a tick."""
    torques: np.ndarray | None = None
    """(n, 2) [N m] that hold the points; without them the rig stays in the pose of the arm in which it is."""
    again: int = 0
    """Point that comes after the last one."""
    ticks: int | None = None
    """Points to follow in all; each once where None."""
    steps: bool = False
    """It declares that it steps: the rig then has no bounds on its speed, acceleration and torque rate."""


def encoded(rows: PlannedRows) -> bytes:
    """int64 (again, ticks, steps, whether torques follow), float64 (n, 2) points, float32 (n, 2) torques."""
    ticks = len(rows.points) if rows.ticks is None else rows.ticks
    words = np.array([rows.again, ticks, rows.steps, rows.torques is not None], np.int64)
    torques = b"" if rows.torques is None else np.ascontiguousarray(rows.torques, np.float32).tobytes()
    return words.tobytes() + np.ascontiguousarray(rows.points, np.float64).tobytes() + torques


def decoded(payload: bytes) -> PlannedRows:
    """What `encoded` gives; ParameterError for a payload that it cannot have given."""
    words = np.frombuffer(payload[:HEAD], np.int64).tolist() if len(payload) >= HEAD else []
    row = POINT + TORQUES if words and words[3] else POINT
    if not words or (len(payload) - HEAD) % row:
        raise ParameterError(f"reference of {len(payload)} bytes is not four int64 words and rows of {row} bytes")
    count = (len(payload) - HEAD) // row
    points = np.frombuffer(payload, count=2 * count, offset=HEAD).reshape(-1, 2)
    torques = None
    if words[3]:
        torques = np.frombuffer(payload, np.float32, offset=HEAD + POINT * count).astype(np.float64).reshape(-1, 2)
    return PlannedRows(points, torques, words[0], words[1], bool(words[2]))
