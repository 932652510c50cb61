"""As much real-time priority as the system grants, and an honest word about what that was."""

import contextlib
import ctypes
import os
import threading
from pathlib import Path

from controller.system.memory import forget_start

FIFO_PRIORITY = 50
NICE = -15
NICE_PROCESS = -10
_PR_SET_TIMERSLACK = 29
_LOCK_CURRENT_FUTURE_ONFAULT = 1 | 2 | 4


def prefer_process() -> None:
    """Before anything else in a process: it and its later threads go before pages, browsers and compilers, if allowed.

    A restart of the rig and the answers to commands must not wait for a busy machine; together they need 5 % of a core.
    """
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, NICE_PROCESS)
        if os.getsid(0) == os.getpid():
            prefer_session(os.getpid())


def prefer_session(process: int) -> None:
    """The same for a session of its own that `process` began: autogrouping kernels weigh whole sessions."""
    with contextlib.suppress(OSError):
        Path(f"/proc/{process}/autogroup").write_text(str(NICE_PROCESS))


def raise_thread_priority() -> str:
    """Raise the calling thread only: SCHED_FIFO, else nice, else nothing; returns what it really has now.

    Threads started later by this thread would inherit the policy, so call it last, inside the loop's own thread.
    """
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO_PRIORITY))
    except OSError:
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
    return thread_policy()


def thread_policy() -> str:
    """Scheduling of the calling thread as the kernel reports it: "SCHED_FIFO 50", "nice -15" or "none"."""
    if os.sched_getscheduler(0) == os.SCHED_FIFO:
        return f"SCHED_FIFO {os.sched_getparam(0).sched_priority}"
    nice = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    return f"nice {nice}" if nice < 0 else "none"


def pin_memory() -> bool:
    """Keep every touched page in memory, but for what only the start needed; False: no locked pages.

    Pages are locked when first touched (MCL_ONFAULT): locking all of them at once would cost the restart its speed.
    """
    forget_start()
    return bool(ctypes.CDLL(None).mlockall(_LOCK_CURRENT_FUTURE_ONFAULT) == 0)
