"""What changed, as events with a type each: told in the event loop, in the order in which they were published."""

from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any, TypeVar

from controller.system.scheduler import Scheduler

E = TypeVar("E")


class EventBus:
    """Events are frozen dataclasses. A subscriber that fails ends no other; it is logged as a job that fails."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._waiting: deque[object] = deque()
        self._subscribers: dict[type, list[tuple[str, Callable[[Any], object]]]] = defaultdict(list)

    def subscribe(self, kind: type[E], name: str, call: Callable[[E], object]) -> None:
        """Have `call` made with every event of this type; `name` says what for, where it fails."""
        self._subscribers[kind].append((name, call))

    def publish(self, event: object) -> None:
        """Tell of `event`, from any thread, once all before it have been told."""
        self._waiting.append(event)
        self._scheduler.soon(self.deliver)

    def deliver(self) -> None:
        """Tell of the events that wait: what subscribers publish meanwhile comes last."""
        while self._waiting:
            event = self._waiting.popleft()
            for name, call in self._subscribers[type(event)]:
                self._scheduler.guard.do(name, lambda call=call, event=event: call(event))  # type: ignore[misc]
