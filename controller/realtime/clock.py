"""The rig's monotonic clock, for compiled code: libc calls that numba can cache (pointers of ctypes cannot be)."""

import numpy as np

from controller.arrays import Words
from controller.numba_internals import types
from controller.realtime.compiled import compiled

SECOND = 1_000_000_000
_MONOTONIC = np.int32(1)
_ABSOLUTE = np.int32(1)
_INTERRUPTED = 4

_words = types.CPointer(types.int64)
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, _words))
_clock_nanosleep = types.ExternalFunction("clock_nanosleep", types.int32(types.int32, types.int32, _words, _words))


@compiled
def now_ns(scratch: Words) -> int:
    """Monotonic time [ns], the same clock as `time.monotonic_ns`; scratch is int64 (4,)."""
    _clock_gettime(_MONOTONIC, scratch.ctypes)
    seconds = scratch[0]
    return int(seconds * SECOND + scratch[1])


@compiled
def sleep_until(scratch: Words, t_ns: int) -> None:
    """Sleep until the monotonic time t_ns [ns]; a signal does not end the sleep early. scratch is int64 (4,)."""
    scratch[0] = t_ns // SECOND
    scratch[1] = t_ns % SECOND
    while _clock_nanosleep(_MONOTONIC, _ABSOLUTE, scratch.ctypes, scratch[2:].ctypes) == _INTERRUPTED:
        pass


@compiled
def slots_missed(now: int, deadline: int, period: int) -> int:
    """Slots of the grid that `now` has already passed, counted from the next `deadline` [all ns]."""
    if now <= deadline:
        return 0
    return (now - deadline) // period + 1
