"""Jobs of the event loop and events in it: in time, in order, and each for itself."""

import asyncio
import contextvars
import threading
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass

import pytest

from controller.system.event_bus import EventBus
from controller.system.scheduler import Job, Scheduler


@dataclass(frozen=True)
class Counted:
    number: int


@dataclass(frozen=True)
class Named:
    name: str


@pytest.fixture
async def scheduler() -> AsyncIterator[Scheduler]:
    found = Scheduler()
    yield found
    found.stop()


async def until(condition: Callable[[], object]) -> None:
    async with asyncio.timeout(60.0):
        while not condition():
            await asyncio.sleep(0.005)


async def test_a_job_that_fails_is_called_again_and_ends_no_other(scheduler: Scheduler) -> None:
    calls: list[str] = []

    def fail() -> None:
        calls.append("fails")
        raise RuntimeError("no")

    scheduler.every(0.01, "the first", fail)
    scheduler.every(0.01, "the second", lambda: calls.append("works"))
    scheduler.start()
    await until(lambda: calls.count("fails") > 3 and calls.count("works") > 3)
    assert scheduler.trouble == "the first fails: RuntimeError: no"
    assert scheduler.age < 10.0


async def test_each_job_keeps_its_own_period(scheduler: Scheduler) -> None:
    calls: list[str] = []
    scheduler.every(0.02, "often", lambda: calls.append("often"))
    scheduler.every(3600.0, "once an hour", lambda: calls.append("once an hour"))
    scheduler.start()
    await until(lambda: calls.count("often") > 9)
    assert calls.count("once an hour") == 1, "at the start"


async def test_a_job_that_is_hastened_comes_at_once_but_not_too_soon_after_the_last(scheduler: Scheduler) -> None:
    calls: list[float] = []
    scheduler.every(3600.0, "hastened", lambda: calls.append(time.monotonic()), 0.1)
    scheduler.start()
    for _ in range(3):
        scheduler.hasten("hastened")
        await asyncio.sleep(0.0)
    await until(lambda: len(calls) == 2)
    assert 0.1 <= calls[1] - calls[0]
    await asyncio.sleep(0.2)
    assert len(calls) == 2, "however often it was hastened"


def test_a_call_that_comes_early_keeps_the_pace_and_one_that_is_late_is_not_made_up_for() -> None:
    job = Job("a", lambda: None, period=1.0, apart=0.0, due=10.0)
    assert job.early == pytest.approx(9.98)
    job.called(9.99)
    assert job.due == 11.0
    job.called(14.5)
    assert job.due == 15.5


async def test_what_is_hastened_by_a_request_runs_outside_of_its_context(scheduler: Scheduler) -> None:
    asker: contextvars.ContextVar[str] = contextvars.ContextVar("asker", default="none")
    seen: list[str] = []
    scheduler.every(3600.0, "a job", lambda: seen.append(asker.get()))
    scheduler.start()

    async def request() -> None:
        asker.set("ann")
        scheduler.hasten("a job")
        scheduler.soon(lambda: seen.append(asker.get()))

    await asyncio.create_task(request())
    await until(lambda: len(seen) == 3)
    assert seen == ["none"] * 3


async def test_events_are_told_in_the_order_of_their_publishing_whatever_thread_publishes(
    scheduler: Scheduler,
) -> None:
    bus, told = EventBus(scheduler), list[object]()
    bus.subscribe(Counted, "one", told.append)
    bus.subscribe(Named, "other", told.append)
    bus.publish(Counted(0))  # before the start
    scheduler.start()

    def publish() -> None:
        for number in range(1, 200):
            bus.publish(Counted(number))
            bus.publish(Named(str(number)))

    thread = threading.Thread(target=publish)
    thread.start()
    await until(lambda: len(told) == 399)
    thread.join()
    assert told == [Counted(0), *(event for n in range(1, 200) for event in (Counted(n), Named(str(n))))]


async def test_what_a_subscriber_publishes_comes_behind_what_was_published_before(scheduler: Scheduler) -> None:
    bus, told = EventBus(scheduler), list[object]()

    def answer(event: Counted) -> None:
        told.append(event)
        if event.number < 2:
            bus.publish(Named(f"after {event.number}"))

    bus.subscribe(Counted, "answers", answer)
    bus.subscribe(Named, "answers", told.append)
    bus.subscribe(Counted, "comes second", lambda event: told.append(f"again {event.number}"))
    for number in range(2):
        bus.publish(Counted(number))
    scheduler.start()
    await until(lambda: len(told) == 6)
    assert told == [Counted(0), "again 0", Counted(1), "again 1", Named("after 0"), Named("after 1")]


async def test_a_subscriber_that_fails_is_told_of_and_keeps_no_other_from_the_event(
    scheduler: Scheduler, caplog: pytest.LogCaptureFixture
) -> None:
    bus, told = EventBus(scheduler), list[object]()

    def fail(event: Counted) -> None:
        raise RuntimeError(f"not {event.number}")

    bus.subscribe(Counted, "the broken one", fail)
    bus.subscribe(Counted, "the other", told.append)
    scheduler.start()
    for number in range(3):
        bus.publish(Counted(number))
    await until(lambda: len(told) == 3)
    assert scheduler.guard.troubles == ["the broken one fails: RuntimeError: not 0, 3 times"]
    assert caplog.text.count("the broken one fails") == 1


async def test_nothing_is_called_after_the_end(scheduler: Scheduler) -> None:
    calls: list[int] = []
    bus = EventBus(scheduler)
    bus.subscribe(Counted, "a subscriber", lambda event: calls.append(event.number))
    scheduler.every(0.01, "a job", lambda: calls.append(-1))
    scheduler.start()
    assert scheduler.stop()
    count = len(calls)
    bus.publish(Counted(1))
    await asyncio.sleep(0.1)
    assert len(calls) == count
