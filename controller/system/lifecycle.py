"""The one life cycle of what works beside its caller: in the event loop, in a thread, in a process."""

from typing import Protocol

DELAY_FIRST, DELAY_MAX = 0.5, 10.0
"""Before what failed once is started again, and after any number of failures in a row [s]."""


class Lifecycle(Protocol):
    """`Scheduler` for the event loop, `SupervisedThread`, `ChildProcess`, and `WorkProcess` on top of it."""

    def start(self) -> None:
        """Begin."""

    def stop(self, timeout: float = 0.0) -> bool:
        """End, within `timeout` [s]; whether it has ended."""

    @property
    def trouble(self) -> str:
        """What is wrong with it, "" if nothing is."""


def retry_delay(failures: int) -> float:
    """Wait after this number of failures in a row [s]: DELAY_FIRST after the first, then doubling."""
    return float(min(DELAY_MAX, DELAY_FIRST * 2.0 ** (failures - 1))) if failures else 0.0
