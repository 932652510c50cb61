"""The one life cycle of what works beside its caller: in the event loop, in a thread, in a process."""

from typing import Protocol


class Lifecycle(Protocol):
    """`Scheduler` for the event loop; threads and processes have the same."""

    def start(self) -> None:
        """Begin."""

    def stop(self, timeout: float = 0.0) -> bool:
        """End, within `timeout` [s]; whether it has ended."""

    @property
    def trouble(self) -> str:
        """What is wrong with it, "" if nothing is."""
