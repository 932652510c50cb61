"""A procedure of ten lines on a scripted rig: by each end rig, settings and log are as they should."""

import asyncio
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any, cast

import pytest

from controller.errors import CommandRefused, NotAllowed
from controller.schema.messages import CommandReply
from controller.schema.modes import Cause, Law, Mode, Request
from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from server.access.lease import OperatorLease
from server.access.permit import Permit, own
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator, Target
from server.operate.procedure.motion import Context
from server.operate.procedure.procedure import Procedure, Procedures
from server.operate.settings import FIRST, KeptSettings
from server.rig.client import Rig
from server.rig.history import History
from tests.server.leave import ANYTHING, permits_of
from tests.server.scripted_rig import ScriptedRig
from tests.server.virtual_time import VirtualLoop

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")


class Nudge(Procedure):
    """The toy of the engine's docstring."""

    async def steps(self) -> None:
        held = await self.ask(Request.HOLD)
        await self.override.put(law=Law.OPEN_LOOP, u_open=(0.0, 0.0))
        await self.follow(held)
        await self.lead((0.0, 0.0), (0.01, 0.0))
        await asyncio.sleep(5.0)
        self.outcome = f"nudged to {self.context.operator.settings.u_open[0]:g} N m"


class Vented(Nudge):
    """The same, which begins vented and comes to rest."""

    rests = True

    async def ask(self, request: Request, target: Target | None = None) -> Any:
        return await super().ask(Request.ARM if request == Request.HOLD else request, target)


class Twice(Nudge):
    """Another one after it."""

    async def steps(self) -> None:
        await super().steps()
        await self.override.put(u_open=(0.02, 0.0))


class Refused(Nudge):
    """A step of it cannot be."""

    error: Exception = CommandRefused("there is no way")

    async def lead(self, *_: Any) -> None:
        raise self.error


class Broken(Refused):
    """A step of it has a mistake in it."""

    error = ZeroDivisionError("by a mistake")


class OneRig(ScriptedRig):
    """Rig and operator in one, which takes settings, and vents where it rests."""

    def change(self, settings: Settings, permit: Permit) -> "Future[CommandReply]":
        answer = self.request(Request.NONE, permit)

        def taken(done: "Future[CommandReply]") -> None:
            if done.exception() is None:
                self.settings = settings

        answer.add_done_callback(taken)
        return answer

    def hold_left(self) -> None:
        self.request(Request.HOLD, own())

    def _tick(self) -> None:
        if self.mode == Mode.REST:
            self.move(Mode.VENTED, Cause.RESTED)
        super()._tick()


class Note:
    """Of an override, in memory."""

    overridden: Settings | None = None

    def note_override(self, settings: Settings | None) -> None:
        self.overridden = settings


class World:
    """The engine on that rig, looked at 60 times a second; ann operates, and is at her page."""

    def __init__(self, folder: Path) -> None:
        self.loop, self.history, self.note, self.events = VirtualLoop(), History(), Note(), EventLog()
        self.lease = OperatorLease(self.loop.time)
        self.rig = OneRig(self.history.add, self.loop.time)
        self.kept = KeptSettings(folder / "settings.json", self.events)
        self.context = Context(
            cast(Rig, self.rig), self.history, cast(Operator, self.rig), self.kept, self.events, self.note
        )
        scheduler = Scheduler()
        scheduler.tell = lambda text: self.events.add(text, "error")
        self.procedures = Procedures(self.context, scheduler, self.loop.time)
        self.lease.acquire(ANN)
        self.permits = permits_of(self.lease)
        self._tasks = [self.loop.create_task(self.rig.run()), self.loop.create_task(self._beat())]
        self.pass_time(0.1)

    def pass_time(self, seconds: float) -> None:
        self.loop.run_until_complete(asyncio.sleep(seconds))

    def start(self, kind: type[Procedure], seconds: float = 2.0, lasting: bool = False) -> Procedure:
        """One that is under way for some time."""
        procedure = kind(self.context, "nudge", self.permits.operator(ANN), lasting)

        async def begin() -> None:
            self.procedures.start(procedure, ", 1 step")

        self.loop.run_until_complete(begin())
        self.pass_time(seconds)
        return procedure

    def log(self) -> list[str]:
        return [event.text for event in self.events.recent]

    def close(self) -> None:
        for task in asyncio.all_tasks(self.loop):
            task.cancel()
        self.pass_time(0.1)
        self.loop.close()

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(1 / 60)
            if (holder := self.lease.holder) is not None:
                self.lease.touch(holder)
                self.permits.operator(holder).sign()
            self.procedures.look()


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    found = World(tmp_path)
    yield found
    found.close()


def change(world: World) -> None:
    wanted = world.rig.settings.model_copy(update={"K_P": (0.1, 0.1)})
    world.rig.change(wanted, world.permits.operator(ANN))


def end(world: World) -> None:
    world.procedures._under_way[0].end("stopped by ann")


def cut(world: World) -> None:
    world.rig.cut = world.rig.deaf = True


def asks(request: Request, who: Permit | None = None, target: Target | None = None) -> Callable[[World], object]:
    return lambda world: world.rig.request(request, who or world.permits.operator(ANN), target)


def goes(mode: Mode, cause: Cause) -> Callable[[World], object]:
    return lambda world: world.rig.move(mode, cause)


ENDS: dict[str, tuple[Callable[[World], object], str, Mode]] = {
    "the operator's stop": (end, "stopped by ann", Mode.HOLD),
    "another request": (asks(Request.REST), "REST, asked for by ann", Mode.VENTED),
    "another target": (asks(Request.NONE, None, (0.2, 0.0)), "another target, asked for by ann", Mode.FOLLOW),
    "E-STOP": (asks(Request.E_STOP, ANYTHING), "E-STOP", Mode.E_STOP),
    "a lost permit": (lambda world: world.lease.give(BOB, "taken over"), "ann no longer operates", Mode.HOLD),
    "a lost presence": (goes(Mode.HOLD, Cause.OPERATOR_LOST), "the rig is in HOLD (operator lost)", Mode.HOLD),
    "a rig that restarted": (lambda world: world.rig.restart(), "the rig restarted", Mode.VENTED),
    "a silent rig": (cut, "the rig is gone", Mode.HOLD),
    "FAULT": (goes(Mode.FAULT, Cause.TRACKING_ERROR), "the rig is in FAULT (tracking error)", Mode.FAULT),
    "E-STOP by the rig": (goes(Mode.E_STOP, Cause.PRESSURE_MISMATCH), "the rig is in E-STOP (", Mode.E_STOP),
    "the server's end": (lambda world: world.loop.create_task(world.procedures.leave()), "the server ended", Mode.HOLD),
    "the server's shutdown": (asks(Request.REST, own()), "REST, asked for by the server", Mode.VENTED),
    "other settings": (change, "the settings were changed", Mode.HOLD),
}


def test_a_procedure_of_ten_lines_goes_to_its_end_and_gives_the_rig_back(world: World) -> None:
    before, nudge = world.rig.settings, world.start(Nudge)
    assert (world.rig.mode, world.rig.settings.law, nudge.running) == (Mode.FOLLOW, Law.OPEN_LOOP, True)
    world.pass_time(10.0)
    assert (nudge.state, nudge.reason, nudge.over) == ("done", "", True)
    assert world.rig.settings == before
    assert world.kept.read() == before.model_copy(update=FIRST)
    assert world.log() == ["ann: nudge started, 1 step", "nudged to 0.01 N m"]


@pytest.mark.parametrize("what", ENDS)
@pytest.mark.parametrize("kind", [Nudge, Vented])
def test_each_end_is_said_and_puts_the_settings_back(world: World, kind: type[Procedure], what: str) -> None:
    act, reason, mode = ENDS[what]
    before = world.rig.settings
    if kind.rests:
        world.rig.move(Mode.VENTED, Cause.START)
        world.pass_time(0.1)
    nudge = world.start(kind, lasting=kind.rests)
    assert (world.rig.mode, world.rig.settings.law) == (Mode.FOLLOW, Law.OPEN_LOOP)
    assert world.note.overridden == (before if kind.rests else None)
    world.loop.call_soon(act, world)
    world.pass_time(1.5)
    assert nudge.state == "ended" and nudge.reason.startswith(reason), nudge.reason
    assert any(line.startswith(f"nudge ended: {reason}") for line in world.log())
    with pytest.raises(NotAllowed):
        nudge.permit.require(Request.FOLLOW)
    world.rig.cut = world.rig.deaf = False
    world.pass_time(5.0)
    assert nudge.over and not world.procedures._under_way
    assert world.rig.mode == (Mode.VENTED if kind.rests and mode in (Mode.HOLD, Mode.FOLLOW) else mode)
    wanted = before.model_copy(update={"K_P": (0.1, 0.1)}) if what == "other settings" else before
    assert world.rig.settings == wanted and world.note.overridden is None


@pytest.mark.parametrize(("kind", "reason"), [(Refused, "there is no way"), (Broken, "the step failed")])
def test_an_error_in_a_step_ends_it_too(world: World, kind: type[Procedure], reason: str) -> None:
    before, nudge = world.rig.settings, world.start(kind)
    assert (nudge.state, nudge.reason, nudge.over, world.rig.mode) == ("ended", reason, True, Mode.HOLD)
    assert world.rig.settings == before and f"nudge ended: {reason}" in world.log()
    assert any("ZeroDivisionError: by a mistake" in line for line in world.log()) == (kind is Broken)


def test_nothing_begins_to_move_where_no_operator_is_present(world: World) -> None:
    world.permits._sign = (-1, 0.0)
    world._tasks[1].cancel()
    before, nudge = world.rig.settings, world.start(Nudge)
    assert "no operator is present" in nudge.reason and nudge.over
    assert (world.rig.mode, world.rig.settings) == (Mode.HOLD, before)


def test_one_that_only_computes_is_ended_by_nothing_that_becomes_of_the_rig(world: World) -> None:
    nudge = world.start(Nudge)
    nudge.has_rig = nudge.follows = False
    world.rig.request(Request.REST, world.permits.operator(ANN))
    world.pass_time(10.0)
    assert (nudge.state, world.rig.mode) == ("done", Mode.VENTED)


def test_what_a_dead_server_had_overridden_is_put_back_by_the_next_one_once_the_rig_is_vented(world: World) -> None:
    before = world.rig.settings
    world.rig.settings = before.model_copy(update={"law": Law.OPEN_LOOP})
    world.note.overridden = before
    world.pass_time(3.0)
    assert (world.rig.mode, world.rig.settings, world.note.overridden) == (Mode.VENTED, before, None)
    assert world.log() == ["the settings that a step of the commissioning had overridden are put back"]


def test_a_rig_that_does_not_answer_is_not_said_to_have_other_settings(world: World) -> None:
    nudge = world.start(Twice)
    world.rig.deaf = True
    world.pass_time(10.0)
    assert nudge.state == "ended" and "did not answer" in nudge.reason, nudge.reason
