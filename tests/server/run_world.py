"""A run's world: the real `Runs`, `Tracker`, `Inbox` and lease, on a scripted rig and a clock that jumps."""

import asyncio
import os
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from controller.assembly.statics import static_map
from controller.errors import TendrilError
from controller.reference.feasible.within_reach import projected
from controller.reference.reference import Reference
from controller.schema.modes import Mode, RowKind
from controller.schema.parameters import RigParameters, Settings
from controller.system.scheduler import Scheduler
from recordings.format.annotations import Annotation, Approach
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.procedure.motion import Context
from server.operate.procedure.procedure import Procedures
from server.operate.settings import KeptSettings
from server.recorder.automatic import Automatic
from server.rig.client import Rig
from server.rig.history import History
from server.rig.planner import Planner
from server.runs import planning
from server.runs.lap import Lap
from server.runs.laps import SETTLE, allowed_by
from server.runs.learning.plans import Plans
from server.runs.messages import RunBody
from server.runs.phases import DEADLINES, ENDS, Phase
from server.runs.results import Results
from server.runs.runs import Runs
from server.runs.tracker import Tracker
from tests.server.leave import permits_of
from tests.server.scripted_rig import ScriptedRig
from tests.server.virtual_time import Inline, VirtualLoop

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")
PATH = np.column_stack([np.full(3000, 0.248), 0.025 - 0.005 * np.cos(2.0 * np.pi * np.arange(3000) / 3000)])
LONG = bool(os.environ.get("TENDRIL_LONG"))
AFTERWARDS = 5.0
"""What begins again by itself has begun within this time [s]."""
SLACK = 0.5
"""Beats, polls and the answer that is under way [s]."""
LONGEST_REQUEST = sum(DEADLINES[phase] for phase in (Phase.PREPARING, Phase.STARTING)) + SLACK


def planned(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    """A line of 3 s, there and back."""
    allowed = allowed_by(rig, settings, drawn=True)
    return Lap(
        "line", np.empty((0, 2)), PATH, 0, torques(), None, np.zeros(len(PATH), bool), allowed, kind=RowKind.DRAWN
    )


def settled(reference: Reference) -> Reference:
    """The same, with the time at its first point that a run stands there."""
    first, waits = reference.start, round(SETTLE * 1e3)
    assert reference.u is not None and reference.travel is not None
    p, u = (np.insert(rows, [first] * waits, rows[first], axis=0) for rows in (reference.p, reference.u))
    return replace(
        reference, p=p, u=u, start=first + waits, travel=np.insert(reference.travel, [first] * waits, values=True)
    )


@cache
def torques() -> Any:
    """What holds P1 along the line (n, 2) [N m]."""
    rig = RigParameters()
    return projected(static_map(rig.actuator, rig.controller), PATH).u


class Recordings:
    """Instead of the recorder: counts."""

    def __init__(self) -> None:
        self.going = self.seconds = 0.0
        self.id = 0

    async def begin_run(self, *_: str) -> None:
        await asyncio.sleep(self.seconds)
        self.going, self.id = 1.0, self.id + 1

    def end_run(self) -> None:
        self.going = 0.0

    def recording(self) -> str | None:
        return str(self.id) if self.going else None

    def annotate(self, annotation: Annotation) -> None:
        assert isinstance(annotation, Approach) and annotation.end > annotation.first


class AtOnce:
    """Instead of the planner's process, which keeps no virtual time; every plan is the same line."""

    async def do(self, work: Any, *arguments: Any) -> Any:
        return await asyncio.to_thread(planned if work is planning.lap else work, *arguments)


class World:
    """Runs on a scripted rig, a beat, and people's requests, each a task."""

    def __init__(self, folder: Path) -> None:
        self.loop = VirtualLoop()
        self.lease, self.events, self.recordings = OperatorLease(self.loop.time), EventLog(), Recordings()
        self.rig = ScriptedRig(lambda rows: self.runs.inbox.put(rows), self.loop.time)
        tracker = Tracker(cast(Rig, self.rig), cast(Operator, self.rig))
        tracker._threads = Inline()
        automatic, self.results = cast(Automatic, self.recordings), Results(folder / "runs.json")
        history, kept = History(), KeptSettings(folder / "settings.json", self.events)
        rig, operator = cast(Rig, self.rig), cast(Operator, self.rig)
        context = Context(rig, history, operator, kept, self.events)
        self.procedures = Procedures(context, Scheduler(), self.loop.time)
        plans = Plans(cast(Planner, AtOnce()), folder / "learned", self.events)
        self.runs = Runs(self.procedures, tracker, plans, automatic, self.results, self.loop.time)
        self.asked: list[tuple[float, asyncio.Task[Any]]] = []
        self.begun = 0
        self.beating = True
        self.tracking_since: float | None = None
        self.lease.acquire(ANN)
        self.permits = permits_of(self.lease)
        self._tasks = [self.loop.create_task(self.rig.run()), self.loop.create_task(self._beat())]
        self.pass_time(0.1)

    @property
    def phase(self) -> Phase | None:
        return self.runs._machine.phase if self.runs._machine else None

    def pass_time(self, seconds: float) -> None:
        self.loop.run_until_complete(asyncio.sleep(seconds))

    def pass_time_until_ended(self, seconds: float) -> None:
        """`seconds` at most: once the run has ended and everybody has an answer, AFTERWARDS more."""
        for _ in range(round(seconds)):
            if self.phase in ENDS and all(task.done() for _, task in self.asked):
                return self.pass_time(AFTERWARDS)
            self.pass_time(1.0)

    def ask(self, verb: str, *body: RunBody, who: Identity = ANN) -> asyncio.Task[Any]:
        task = self.loop.create_task(self._asked(verb, *body, who=who))
        self.asked.append((self.loop.time(), task))
        return task

    async def _asked(self, verb: str, *body: RunBody, who: Identity) -> Any:
        try:
            return await getattr(self.runs, verb)(*body, self.permits.operator(who))
        except TendrilError as error:
            return error

    def close(self) -> None:
        for task in [*self._tasks, *(task for _, task in self.asked)]:
            task.cancel()
        self.pass_time(0.1)
        self.loop.close()
        self.results.close()

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(1 / 60)
            holder = self.lease.holder
            if holder is not None:
                self.lease.touch(holder)
                self.permits.operator(holder).sign()
            if self.beating:
                self.procedures.look()
            tracks = self.rig.mode == Mode.TRACK
            self.tracking_since = (self.tracking_since or self.loop.time()) if tracks else None
