"""Every way from outside to the rig is listed here, and asks a permit where the request leaves: a new one fails."""

import ast
import asyncio
import threading
from collections.abc import Awaitable, Callable, Generator, Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from controller.errors import TendrilError
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, CommandReply, Telemetry, TwinFaults
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import Settings
from server.access.lease import OperatorLease
from server.access.permit import Permit
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.people import PeopleHere
from server.operate.procedure.motion import ask
from server.operate.stopper import Stopper
from server.rig.client import Rig
from tests.server.leave import permits_of

SERVER = Path(__file__).parents[3] / "server"
DOORS = {
    "app/services.py": ["send", "stop"],
    "app/shutdown.py": ["request"],
    "hardware/commissioning/routes.py": ["present", "present"],
    "hardware/rig_file.py": ["request_rig"],
    "live/socket_handler.py": ["stop"],
    "operate/command_routes.py": ["stop"],
    "operate/target_control.py": ["present", "request", "request", "request", "request"],
    "operate/people.py": ["request"],
    "operate/settings.py": ["change"],
    "operate/reactions.py": ["hold_left"],
    "hardware/routes.py": ["present", "request_actuator", "request_rig", "request_rig"],
    "operate/procedure/motion.py": ["ask", "move", "request"],
    "operate/procedure/procedure.py": ["hold_left", "request", "request", "request"],
    "rig/client.py": ["command", "faults", "faults", "plan", "stop"],
    "rig/twin_routes.py": ["inject"],
    "runs/macros/routes.py": ["present", "present"],
    "runs/routes.py": ["present", "present", "present"],
    "runs/tracker.py": ["plan", "request", "request"],
}
"""What reaches the operator's side, the link or the supervisor's order, by file; the campaign asks from outside."""
PARTS = {
    "operator": {"request", "move", "change", "present", "stop", "hold_left"},
    "rig": {"plan", "inject", "stop", "send"},
    "link": {"command", "plan", "faults", "stop"},
    "restart_files": {"request_actuator", "request_rig"},
}
"""Names by which these parts are held, and their ways to the rig."""
ANN, BOB = Identity("a", "ann", "operator"), Identity("b", "bob", "operator")


def calls(path: Path) -> Iterator[str]:
    """Each mention of a way to the rig in this file, a reference that is handed on included."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Attribute):
            holder = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
            if node.attr.lstrip("_") in PARTS.get(holder.lstrip("_"), ()):
                yield node.attr
        elif isinstance(node, ast.Name) and node.id == ask.__name__:
            yield node.id


def test_every_door_to_the_rig_is_known() -> None:
    files = [path for path in SERVER.rglob("*.py") if "campaign" not in path.relative_to(SERVER).parts[:1]]
    found = {str(path.relative_to(SERVER)): sorted(calls(path)) for path in files}
    assert {name: ways for name, ways in found.items() if ways} == DOORS


class Wire:
    """The link: keeps what left for the rig. The operator's thread passes `gate` before it looks at anything."""

    def __init__(self) -> None:
        self.left: list[str] = []
        self.gate = threading.Event()
        self.gate.set()
        self.row = np.zeros(1, record_dtype(Telemetry))
        self.row["mode"] = Mode.HOLD

    def newest(self) -> Any:
        if threading.current_thread().name == "operator":
            self.gate.wait(20)
        return self.row

    def command(self, command: Command) -> CommandReply:
        if command.request not in (Request.NONE, Request.HOLD) or command.settings != Settings():
            self.left.append(command.request.name)
        return CommandReply(n=command.n, accepted=True, mode=Mode.HOLD, cause=Cause.NONE, detail="")

    def plan(self, rows: Any) -> None:
        self.left.append("plan")

    def faults(self, wanted: TwinFaults) -> TwinFaults:
        self.left.append("faults")
        return wanted


class Desk:
    """The server's side of the rig on that wire, with ann operating."""

    def __init__(self) -> None:
        self.wire, self.lease = Wire(), OperatorLease()
        self.permits = permits_of(self.lease)
        stopper = Stopper(lambda number: self.wire.command(Command()), lambda: 7)
        self.operator = Operator(self.wire.command, lambda: 7, self.wire.newest, Settings(), stopper)
        self.rig = cast(Rig, object.__new__(Rig))
        self.rig._link = cast(Any, self.wire)
        self.people = PeopleHere(lambda: [ANN, BOB], self.lease, self.operator, self.permits, EventLog())
        self.lease.acquire(ANN)

    def passed(self, call: Callable[[], object]) -> None:
        """A call in a thread begins, too, once the gate is open."""
        self.wire.gate.wait(20)
        call()

    def permit(self) -> Permit:
        found = self.permits.operator(ANN)
        self.operator.present(found)
        return found


async def _request(desk: Desk, request: Request, permit: Permit) -> None:
    await asyncio.wrap_future(desk.operator.request(request, permit, (0.1, 0.0)))


async def _run(desk: Desk, permit: Permit) -> None:
    """As a run does: it plans, holds, sends its rows, and asks for TRACK."""
    await asyncio.to_thread(lambda: None)
    await _request(desk, Request.HOLD, permit)
    await asyncio.to_thread(desk.passed, lambda: desk.rig.plan(cast(Any, None), permit))
    await _request(desk, Request.TRACK, permit)


async def _change(desk: Desk, permit: Permit) -> None:
    """As a change of settings does, which waits for its turn."""
    lock = asyncio.Lock()
    await lock.acquire()
    asyncio.get_running_loop().call_later(0.01, lock.release)
    async with lock:
        await asyncio.wrap_future(desk.operator.change(Settings(K_P=(1.0, 1.0)), permit))


async def _move(desk: Desk, permit: Permit) -> None:
    await _request(desk, Request.FOLLOW, permit)
    await asyncio.wrap_future(desk.operator.move((0.2, 0.0), permit))


async def _inject(desk: Desk, permit: Permit) -> None:
    await asyncio.to_thread(desk.passed, lambda: desk.rig.inject(TwinFaults(noise=0.01), permit))


async def _hand_over(desk: Desk, permit: Permit) -> None:
    await desk.people.hand_over(BOB.tag, ANN)
    desk.wire.left.append("handed over")


ACTS: dict[str, Callable[[Desk, Permit], Awaitable[None]]] = {
    "arm": lambda desk, permit: _request(desk, Request.ARM, permit),
    "follow and move": _move,
    "run": _run,
    "settings": _change,
    "faults of the twin": _inject,
    "hand over": _hand_over,
}


class LostAt:
    """Runs a coroutine; at its await number `at` control passes on, before anything asked since can have left."""

    def __init__(self, desk: Desk, act: Awaitable[None], at: int) -> None:
        self._desk, self._act, self._at = desk, act, at
        self.reached = False

    def __await__(self) -> Generator[Any, None, None]:
        steps, count, gate = cast(Any, self._act), 0, self._desk.wire.gate
        while True:
            gate.clear()
            try:
                waited = steps.send(None)
            except StopIteration:
                return
            finally:
                if count == self._at:
                    self.reached = True
                    self._desk.lease.give(Identity("c", "eve", "operator"), "taken over")
                    self._desk.wire.left.clear()
                gate.set()
            count += 1
            yield waited


@pytest.mark.parametrize("act", ACTS)
async def test_nothing_leaves_for_the_rig_after_control_is_lost_at_any_await(act: str) -> None:
    at = 0
    while True:
        desk = Desk()
        try:
            lost = LostAt(desk, ACTS[act](desk, desk.permit()), at)
            try:
                await lost
            except TendrilError:
                pass
            if not lost.reached:
                assert desk.wire.left, "with control kept it is done"
                return
            assert desk.wire.left == [], f"{desk.wire.left} left after await {at}"
        finally:
            desk.operator.close()
        at += 1
