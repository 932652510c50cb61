"""A process that is of no use without the one that started it."""

import ctypes
import signal

PR_SET_PDEATHSIG = 1
"""prctl(2)."""


def end_with_parent() -> None:
    """Be sent SIGTERM when the thread that started this process ends, however that happens; Linux only."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
