"""Where the threads of a rig's drivers meet the loop: markers and pressures become one Measurement in its mailbox."""

import threading
import time
from collections.abc import Callable

import numpy as np

from controller.arrays import Array
from controller.drivers.device import Reading
from controller.schema.layout import record_dtype
from controller.schema.messages import Measurement

Post = Callable[[np.ndarray], None]
"""Takes an array of one Measurement record; never from two threads at once."""
CLOCKS_DIFFER_NS = 3_000_000
NEVER = 1
"""A time long past, for pressures that no one has read yet: 0 would say that they are always fresh [ns]."""


class Inlet:
    """Holds the newest of both kinds, and posts both at each arrival."""

    def __init__(self, post: Post) -> None:
        self._post, self._lock = post, threading.Lock()
        self._record = np.zeros(1, record_dtype(Measurement))
        self._record["markers"] = np.nan
        self._record["pressures_ns"] = NEVER
        self._put()

    def take_markers(self, t_ns: int, markers: Array) -> bool:
        """Markers (10,2) [m], captured at `t_ns` on our clock; False for what is older than the newest, or to come."""
        with self._lock:
            if not self._record[0]["t_ns"] < t_ns <= time.monotonic_ns():
                return False
            self._record["t_ns"], self._record["markers"] = t_ns, markers
            self._put()
        return True

    def take_reading(self, reading: Reading) -> bool:
        """Pressures (4,) [Pa]; they only count as fresh while the board obeys. False for what is old, or to come.

        A little older than the newest is as good: estimates of a board's clock differ by as much.
        """
        with self._lock:
            newest = int(self._record[0]["pressures_ns"])
            if not newest - CLOCKS_DIFFER_NS < reading.t_ns <= time.monotonic_ns():
                return False
            self._record["pressures"] = reading.pressures
            if not reading.stopped:
                self._record["pressures_ns"] = max(newest, reading.t_ns)
            self._put()
        return True

    def _put(self) -> None:
        self._post(self._record)
