import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from controller.realtime.clock import now_ns, sleep_until, slots_missed

pytestmark = pytest.mark.alone

MILLISECOND = 1_000_000


def test_it_is_the_monotonic_clock_of_python() -> None:
    before = time.monotonic_ns()
    assert before <= now_ns(np.zeros(4, np.int64)) <= time.monotonic_ns()


def test_a_sleep_never_ends_before_its_time_even_when_a_signal_comes() -> None:
    signal.signal(signal.SIGALRM, lambda *_: None)
    signal.setitimer(signal.ITIMER_REAL, 0.005, 0.005)
    try:
        scratch = np.zeros(4, np.int64)
        end = now_ns(scratch) + 50 * MILLISECOND
        sleep_until(scratch, end)
        assert now_ns(scratch) >= end
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


@pytest.mark.parametrize(("late", "missed"), [(-1, 0), (0, 0), (1, 1), (999_999, 1), (1_000_000, 2), (5_500_000, 6)])
def test_every_slot_whose_deadline_has_passed_is_missed(late: int, missed: int) -> None:
    assert slots_missed(10 * MILLISECOND + late, 10 * MILLISECOND, MILLISECOND) == missed


def test_the_policy_is_what_the_kernel_says_with_rights_and_without() -> None:
    assert raise_in_child("") in ("SCHED_FIFO 50", "nice -15", "none")
    assert raise_in_child("import os; os.setgroups([]) if os.getuid() == 0 else None; os.setuid(65534);") == "none"


def raise_in_child(before: str) -> str:
    code = f"from controller.realtime.priority import raise_thread_priority; {before} print(raise_thread_priority())"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_only_the_calling_thread_is_raised() -> None:
    code = (
        "import os, threading; from controller.realtime.priority import raise_thread_priority;"
        "t = threading.Thread(target=raise_thread_priority); t.start(); t.join();"
        "print(os.sched_getscheduler(0) == os.SCHED_OTHER and os.getpriority(os.PRIO_PROCESS, 0) == 0)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "True"
