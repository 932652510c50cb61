"""What the rig did, read from its own ring: rows since a time, and whether anything moved in them."""

import time

import numpy as np

from controller.arrays import Rows
from controller.realtime.ring import CAPACITY, find_ring
from controller.schema.modes import Cause, Mode
from controller.schema.states import MOVING

STILL = 1e-6
"""Way of a reference that counts as none [m]."""
GROWTH = 1e-9
"""Change of a torque that counts as none [N m]."""


def newest(rig: str) -> np.void:
    """The newest row of the newest boot of `rig`; RigUnreachable without a ring."""
    while (row := find_ring(rig).newest()) is None:
        time.sleep(1e-3)
    return row


def since(rig: str, t_ns: int) -> Rows:
    """Rows (n,) from the time `t_ns` of the monotonic clock on, as far as the ring of the newest boot holds them."""
    ring = find_ring(rig)
    count = min(CAPACITY - 1, max(0, time.monotonic_ns() - t_ns) // 1_000_000 + 1000)
    rows = ring.read(max(0, ring.head - count), count)[1]
    return rows[rows["t_ns"] >= t_ns]


def calm(rows: Rows) -> str:
    """What moved in `rows`, "" if nothing did: HOLD keeps its reference, REST and FAULT only lose torque."""
    mode = rows["mode"]
    if np.isin(mode, MOVING).any():
        return f"the rig was in {Mode(mode[np.isin(mode, MOVING)][0]).name}"
    held = rows["p_ref"][mode == Mode.HOLD]
    if len(held) and np.ptp(held, axis=0).max() > STILL:
        return f"the reference went {1e3 * np.ptp(held, axis=0).max():.2f} mm in HOLD"
    if np.any(rows["pressure_cmd"][np.isin(mode, (Mode.VENTED, Mode.E_STOP))]):
        return "pressure was commanded while vented"
    for falling in (Mode.REST, Mode.FAULT):
        if np.any(np.diff(np.abs(rows["u"][mode == falling]), axis=0) > GROWTH):
            return f"a torque rose in {falling.name}"
    return ""


def longest_gap_ms(rows: Rows) -> float:
    """Longest time between two ticks [ms]."""
    return float(np.diff(rows["t_ns"]).max(initial=0)) * 1e-6


def told(row: np.void) -> str:
    """Mode and cause, as "HOLD (server lost)"."""
    return f"{Mode(row['mode']).name} ({Cause(row['cause']).name.replace('_', ' ').lower()})"
