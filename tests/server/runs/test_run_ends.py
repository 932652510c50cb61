"""How runs end that no row ends: a lost lease, another boot of the rig, silence; and what is kept of them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from controller.arrays import Rows
from controller.errors import CommandRefused
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters, Settings
from controller.system.scheduler import Scheduler
from server.access.lease import OperatorLease
from server.access.permit import Permit
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.procedure.motion import Context
from server.operate.procedure.procedure import Procedures
from server.recorder.automatic import Automatic
from server.runs.lap import Leg
from server.runs.learning.plans import Plans
from server.runs.messages import RunBody
from server.runs.results import KEPT, Results
from server.runs.run import Before
from server.runs.runs import SILENCE_MAX_S, Runs
from server.runs.tracker import Held
from tests.server.leave import permits_of
from tests.server.live_server import PLANNER

pytestmark = pytest.mark.process

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")
CIRCLE = RunBody(reference="circle_1hz", laps=None)


class Rig:
    """Stands in for the rig and its operator; the test writes the rows."""

    def __init__(self) -> None:
        self.boot_id, self.silent, self.tick = 7, 0.0, 0
        self.settings = Settings()
        self.refuses = False
        self.again = self.let_go = 0

    def require_ready(self) -> Any:
        return SimpleNamespace(boot=self.boot_id, parameters=RigParameters(), controllers=())

    @property
    def info(self) -> Any:
        return self.require_ready()

    @property
    def age(self) -> float:
        return self.silent

    def require_info(self) -> Any:
        return self.info

    def listen(self, hears: object) -> None:
        pass

    async def hold(self, permit: Permit) -> Held:
        await self.halt(permit)
        return Held(np.zeros(2), Before(self.tick - 1))

    async def halt(self, permit: Permit) -> int:
        if self.refuses:
            raise CommandRefused("not now")
        self.runs.inbox.put(self.rows(Mode.HOLD, 2))
        return 0

    def let_hold(self) -> None:
        self.let_go += 1

    async def upload(self, leg: Leg, permit: Permit) -> None:
        self.again = leg.again

    async def track(self, permit: Permit) -> None:
        if self.refuses:
            raise CommandRefused("not now")
        self.runs.inbox.put(self.rows(Mode.TRACK, self.again + 100))

    def rows(self, mode: Mode, count: int, cause: Cause = Cause.OPERATOR) -> Rows:
        rows = np.zeros(count, record_dtype(Telemetry))
        rows["tick"] = rows["slot"] = self.tick + np.arange(count)
        rows["mode"], rows["cause"] = mode, cause
        self.tick += count
        return rows


async def nothing(*_: str) -> None:
    """Instead of beginning a recording."""


class Desk:
    """Runs on such a rig, with ann operating."""

    def __init__(self, folder: Path) -> None:
        self.rig, self.lease, self.events = Rig(), OperatorLease(lambda: 0.0), EventLog()
        self.results = Results(folder / "runs.json")
        ignored = {"end_run": lambda: None, "recording": lambda: None, "annotate": lambda annotation: None}
        automatic = cast(Automatic, SimpleNamespace(begin_run=nothing, **ignored))
        rig: Any = self.rig
        self.procedures = Procedures(Context(rig, cast(Any, None), rig, cast(Any, None), self.events), Scheduler())
        plans = Plans(PLANNER, folder / "learned", self.events)
        self.runs = Runs(self.procedures, rig, plans, automatic, self.results)
        self.rig.runs = self.runs  # type: ignore[attr-defined]
        self.lease.acquire(ANN)

    async def running(self) -> Runs:
        await self.runs.start(CIRCLE, self.leave(ANN))
        self.runs.look()
        assert self.phase == "running"
        return self.runs

    def leave(self, who: Identity) -> Permit:
        return permits_of(self.lease).operator(who)

    @property
    def phase(self) -> str:
        state = self.runs.state()
        return state.state if state else ""

    @property
    def reason(self) -> str:
        last = self.runs.last()
        return last.reason if last else ""


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


async def test_who_loses_the_lease_loses_the_run_when_the_rig_holds(desk: Desk) -> None:
    runs = await desk.running()
    desk.lease.release(ANN)
    runs.look()
    assert desk.phase == "running", "the rig is asked to hold by the watch"
    runs.inbox.put(desk.rig.rows(Mode.HOLD, 3))
    runs.look()
    assert (desk.phase, desk.reason) == ("broken off", "ann no longer operates")


async def test_a_paused_run_is_nobody_else_s(desk: Desk) -> None:
    runs = await desk.running()
    assert (await runs.pause(desk.leave(ANN))).state == "paused"
    desk.lease.release(ANN)
    desk.lease.acquire(BOB)
    runs.look()
    assert (desk.phase, desk.reason) == ("broken off", "ann no longer operates")
    with pytest.raises(CommandRefused, match="no run is under way"):
        await runs.resume(desk.leave(BOB))


async def test_another_life_of_the_rig_or_its_silence_ends_the_run(desk: Desk) -> None:
    runs = await desk.running()
    desk.rig.boot_id = 8
    runs.inbox.put(desk.rig.rows(Mode.VENTED, 3, Cause.START))
    runs.look()
    assert (desk.phase, desk.reason) == ("broken off", "the rig restarted")
    await desk.running()
    desk.rig.silent = SILENCE_MAX_S + 1.0
    runs.look()
    assert (desk.phase, desk.reason) == ("broken off", "the rig is gone")
    assert [result.id for result in runs.results()] == [2, 1]


async def test_what_the_rig_refuses_leaves_the_run_as_it_was(desk: Desk) -> None:
    desk.rig.refuses = True
    with pytest.raises(CommandRefused, match="not now"):
        await desk.runs.start(CIRCLE, desk.leave(ANN))
    assert desk.runs.state() is None
    desk.rig.refuses = False
    runs = await desk.running()
    desk.rig.refuses = True
    with pytest.raises(CommandRefused, match="not now"):
        await runs.pause(desk.leave(ANN))
    runs.look()
    assert desk.phase == "running"
    desk.rig.refuses = False
    await runs.pause(desk.leave(ANN))
    desk.rig.refuses = True
    with pytest.raises(CommandRefused, match="not now"):
        await runs.resume(desk.leave(ANN))
    assert desk.phase == "paused"
    desk.rig.refuses = False
    await runs.resume(desk.leave(ANN))
    with pytest.raises(CommandRefused, match="is not paused"):
        await runs.resume(desk.leave(ANN))
    assert (await runs.stop(desk.leave(ANN))).state == "stopped"
    with pytest.raises(CommandRefused, match="no run is under way"):
        await runs.stop(desk.leave(ANN))
    told = [event.text for event in desk.events.recent]
    assert told[:4] == [f"run 1 (Circle, 1 Hz) {what} by ann" for what in ("started", "paused", "resumed")] + told[3:4]
    assert told[3].startswith("run 1 (Circle, 1 Hz) stopped: by ann, RMSE ")


async def test_the_last_results_outlive_the_server(desk: Desk, tmp_path: Path) -> None:
    runs = await desk.running()
    await runs.stop(desk.leave(ANN))
    for _ in range(KEPT):
        desk.results.add(desk.runs.results()[0].model_copy(update={"id": desk.results.next_id()}))
    desk.results.close()
    again = Results(tmp_path / "runs.json")
    assert again.all() == runs.results()
    assert [again.all()[0].id, again.all()[-1].id, again.next_id()] == [KEPT + 1, 2, KEPT + 2]
    (tmp_path / "runs.json").write_text("no JSON")
    assert Results(tmp_path / "runs.json").newest is None


async def test_a_run_that_its_server_does_not_outlive_is_kept_too(desk: Desk, tmp_path: Path) -> None:
    (await desk.running()).close()
    desk.runs.close()
    desk.results.close()
    assert [result.reason for result in Results(tmp_path / "runs.json").all()] == ["the server ended"]


async def test_a_state_folder_that_cannot_be_written_is_said(desk: Desk, tmp_path: Path) -> None:
    (tmp_path / "blocked").write_text("")
    desk.runs._results = Results(tmp_path / "blocked" / "runs.json")
    for _ in range(2):
        await desk.running()
        assert (await desk.runs.stop(desk.leave(ANN))).state == "stopped"
        saving = desk.runs._results._saving
        assert saving is not None and isinstance(saving.exception(60.0), OSError)
    assert "will not outlive" in desk.events.recent[-1].text
