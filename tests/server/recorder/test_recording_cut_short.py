"""A recorder at work when who waits for it is cancelled: what it begins is ended, and what it ends is looked after."""

import asyncio
import threading
from collections.abc import Coroutine
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.format.messages import Recording, RecordingState
from recordings.write.writer import Recorder
from server.log.events import EventLog
from server.operate.operator import Operator
from server.recorder.automatic import Automatic
from server.recorder.by_hand import RecordingByHand
from server.recorder.folder import RecordingsFolder
from server.recorder.review import Review
from server.rig.client import Rig


class SlowRecorder:
    """Begins and ends when it may go on, as with a slow disk."""

    def __init__(self) -> None:
        self.may_start, self.may_stop = threading.Event(), threading.Event()
        self.begun: list[str] = []
        self.going = ""

    def start(self, name: str, *_: Any) -> RecordingState:
        assert self.may_start.wait(10.0) and not self.going
        self.going = f"{name} {len(self.begun)}"
        self.begun.append(self.going)
        return self.state()

    def stop(self) -> Recording:
        assert self.may_stop.wait(10.0)
        id, self.going = self.going, ""
        return cast(Recording, SimpleNamespace(id=id, rows=0, gaps=0))

    def state(self) -> RecordingState:
        return RecordingState(recording=bool(self.going), id=self.going, seconds=0.0, rows=0, gaps=0)

    def first(self) -> str:
        return self.going


class Desk:
    """Such a recorder, and who asks it."""

    def __init__(self) -> None:
        self.recorder, self.events, self.looked_after = SlowRecorder(), EventLog(), list[str]()
        recorder = cast(Recorder, self.recorder)
        review = cast(Review, SimpleNamespace(stopped=self.looked_after.append))
        self.heard = SimpleNamespace(info=1, require_info=lambda: 1, newest=None, boot=lambda: None)
        rig = cast(Rig, self.heard)
        self.automatic = Automatic(recorder, rig, review, self.events, Settings, lambda: True, Scheduler())
        operator = cast(Operator, SimpleNamespace(settings=Settings()))
        self.by_hand = RecordingByHand(
            recorder, cast(RecordingsFolder, None), review, rig, operator, self.events, Scheduler()
        )

    async def fault(self) -> str:
        """The rig is stopped under pressure: the id of the recording that this begins."""
        for mode in (Mode.HOLD, Mode.E_STOP):
            self.heard.newest = np.zeros(1, record_dtype(Telemetry))
            self.heard.newest["mode"] = mode
            self.automatic.look()
        async with asyncio.timeout(10.0):
            while not self.recorder.going:
                await asyncio.sleep(0.01)
        await asyncio.sleep(0.05)
        return self.recorder.going


async def cancelled(waiting: Coroutine[Any, Any, Any]) -> None:
    """Begin it, and wait for it no longer."""
    task = asyncio.create_task(waiting)
    await asyncio.sleep(0.05)
    task.cancel()
    await asyncio.wait([task])
    assert task.cancelled()


async def until(desk: Desk, ids: list[str]) -> None:
    async with asyncio.timeout(10.0):
        while desk.looked_after != ids:
            await asyncio.sleep(0.01)


async def cut_short(desk: Desk, name: str) -> None:
    """Ask for the recording of a run that is over before its recording has begun."""
    run = asyncio.create_task(desk.automatic.begin_run(name, "ann"))
    await asyncio.sleep(0.05)
    desk.automatic.end_run()
    run.cancel()


async def test_a_run_that_is_over_as_its_recording_begins_leaves_none_behind() -> None:
    desk = Desk()
    desk.recorder.may_stop.set()
    await cut_short(desk, "ring")
    desk.recorder.may_start.set()
    await until(desk, ["ring 0"])
    assert not desk.recorder.going


async def test_a_run_that_follows_at_once_is_recorded_apart() -> None:
    desk = Desk()
    await cut_short(desk, "ring")
    second = asyncio.create_task(desk.automatic.begin_run("line", "ann"))
    await asyncio.sleep(0.05)
    desk.recorder.may_start.set()
    desk.recorder.may_stop.set()
    await asyncio.wait_for(second, 10.0)
    assert (desk.looked_after, desk.recorder.going) == (["ring 0"], "line 1")
    desk.automatic.end_run()
    await until(desk, ["ring 0", "line 1"])


async def test_a_run_that_was_over_before_the_recorder_was_asked_is_not_recorded() -> None:
    desk = Desk()
    desk.recorder.may_start.set()
    await desk.automatic.begin_run("ring", "ann")
    desk.automatic.end_run()  # which takes long
    await cut_short(desk, "line")
    desk.recorder.may_stop.set()
    await until(desk, ["ring 0"])
    await asyncio.sleep(0.05)
    assert desk.recorder.begun == ["ring 0"]


async def test_a_fault_whose_recording_a_cancelled_run_ended_is_looked_after() -> None:
    desk = Desk()
    desk.recorder.may_start.set()
    fault = await desk.fault()
    await cancelled(desk.automatic.begin_run("ring", "ann"))
    desk.automatic.end_run()
    desk.recorder.may_stop.set()
    await until(desk, [fault])
    assert desk.recorder.begun == [fault]


async def test_a_macro_that_is_ended_while_it_ends_a_recording_leaves_it_to_the_review() -> None:
    desk = Desk()
    desk.recorder.may_start.set()
    await desk.by_hand.begin("warm", "standard", "ann")
    await cancelled(desk.by_hand.end("ann"))
    desk.recorder.may_stop.set()
    await until(desk, ["warm 0"])
    assert any("ann: recording warm 0 stopped" in event.text for event in desk.events.recent)


async def test_a_recording_that_a_macro_began_as_it_ended_is_in_the_log() -> None:
    desk = Desk()
    await cancelled(desk.by_hand.begin("warm", "standard", "ann"))
    desk.recorder.may_start.set()
    async with asyncio.timeout(10.0):
        while not any("ann: recording warm 0 started" in event.text for event in desk.events.recent):
            await asyncio.sleep(0.01)
