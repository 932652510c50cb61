"""Who may act is looked at where the request leaves for the rig, not where it came in."""

import asyncio
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest

from controller.errors import CommandRefused, NotAllowed
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, CommandReply, Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import Settings
from server.access import lease
from server.access.lease import OperatorLease
from server.access.permit import Permit, own
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.people import PeopleHere
from server.operate.stopper import Stopper
from tests.server.leave import permits_of

ANN, BOB, EVE = (Identity(name, name, "operator") for name in ("ann", "bob", "eve"))


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


class Desk:
    """An operator whose thread waits before it looks at anything, and what it sent to a rig that takes all."""

    def __init__(self) -> None:
        self.clock, self.sent = Clock(), list[Command]()
        self.lease = OperatorLease(self.clock)
        self.permits = permits_of(self.lease)
        self.gate = threading.Event()
        self.gate.set()
        self.row = np.zeros(1, record_dtype(Telemetry))
        stopper = Stopper(lambda number: self._send(Command()), lambda: 7)
        self.operator = Operator(self._send, lambda: 7, self._newest, Settings(), stopper)

    def _newest(self) -> Any:
        if threading.current_thread().name == "operator":
            self.gate.wait(20)
        return self.row

    def _send(self, command: Command) -> CommandReply:
        self.sent.append(command)
        return CommandReply(n=command.n, accepted=True, mode=Mode.HOLD, cause=Cause.NONE, detail="")

    def asked(self) -> list[Request]:
        return [command.request for command in self.sent if command.request]


@pytest.fixture
def desk() -> Iterator[Desk]:
    found = Desk()
    yield found
    found.gate.set()
    found.operator.close()


def refused(future: "Future[CommandReply]") -> str:
    with pytest.raises(NotAllowed) as error:
        future.result(20)
    return str(error.value)


@pytest.mark.parametrize("to", [None, BOB, ANN])
def test_what_waits_when_control_is_lost_never_leaves(to: Identity | None, desk: Desk) -> None:
    """Nor when its asker has control again: that is another term, and asks for a fresh action."""
    desk.lease.acquire(ANN)
    permit = desk.permits.operator(ANN)
    desk.operator.present(permit)
    desk.gate.clear()
    waiting = [
        desk.operator.request(Request.ARM, permit),
        desk.operator.change(Settings(K_P=(1.0, 1.0)), permit),
        desk.operator.request(Request.FOLLOW, permit, (0.1, 0.0)),
        desk.operator.move((0.2, 0.0), permit),
        desk.operator.request(Request.TRACK, permit),
    ]
    desk.lease.release(ANN)
    if to is not None:
        desk.lease.acquire(to)
    desk.gate.set()
    for future in waiting:
        assert "operate" in (why := refused(future)) or "asked" in why
    assert desk.asked() == []
    assert {(c.target, c.settings, c.presence) for c in desk.sent} <= {((0.0, 0.0), Settings(), 0)}


def test_a_lapsed_lease_and_an_ended_session_are_noticed_there_too(desk: Desk) -> None:
    desk.lease.acquire(ANN)
    permit = desk.permits.operator(ANN)
    desk.gate.clear()
    waiting = desk.operator.request(Request.ARM, permit)
    desk.clock.now = lease.LAPSE_S + 0.1
    desk.gate.set()
    assert "no one operates" in refused(waiting)
    desk.lease.acquire(ANN)
    desk.permits._sessions.stands = lambda who: False  # type: ignore[method-assign]
    assert "session has ended" in refused(desk.operator.request(Request.ARM, desk.permits.operator(ANN)))


@pytest.mark.parametrize("request_", [Request.FOLLOW, Request.TRACK])
def test_nothing_begins_to_move_without_a_sign_of_the_operators_own_page(request_: Request, desk: Desk) -> None:
    desk.lease.acquire(BOB)
    desk.operator.present(desk.permits.operator(BOB))
    desk.lease.give(ANN, "ann took control over")
    permit = desk.permits.operator(ANN)
    assert "since control was taken" in refused(desk.operator.request(request_, permit))
    desk.operator.present(permit)
    assert desk.operator.request(request_, permit).result(20).accepted
    desk.clock.now = 0.6
    assert "0.6 s, the most is 0.5 s" in refused(desk.operator.request(request_, permit))
    assert desk.operator.request(Request.HOLD, permit).result(20).accepted, "who ends motion need not be present"


def test_a_sign_of_who_no_longer_operates_is_no_presence(desk: Desk) -> None:
    desk.lease.acquire(ANN)
    permit = desk.permits.operator(ANN)
    desk.gate.clear()
    desk.operator.present(permit)
    desk.lease.give(BOB, "bob took control over")
    desk.gate.set()
    desk.operator.request(Request.HOLD, own()).result(20)
    desk.operator.present(permit)
    desk.operator.request(Request.HOLD, own()).result(20)
    assert {command.presence for command in desk.sent} == {0}


@pytest.mark.parametrize("request_", [one for one in Request if one not in (Request.NONE, Request.E_STOP)])
def test_by_itself_the_server_only_ends_motion(request_: Request, desk: Desk) -> None:
    asked = desk.operator.request(request_, own())
    if request_ in (Request.HOLD, Request.REST):
        assert asked.result(20).accepted
    else:
        assert "HOLD or REST alone" in refused(asked)


class Slow:
    """An operator whose HOLD is answered when the test says so, and that looks at permits as the real one does."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Permit, Future[None]]] = []

    def request(self, request: Request, permit: Permit) -> "Future[None]":
        self.waiting.append((permit, Future()))
        return self.waiting[-1][1]


async def test_a_take_over_confirmed_against_one_takes_from_no_other() -> None:
    held, slow = OperatorLease(), Slow()
    people: Any = PeopleHere(lambda: [ANN, BOB, EVE], held, slow, permits_of(held), EventLog())  # type: ignore[arg-type]
    held.acquire(ANN)
    taking = asyncio.create_task(people.take_over(ANN.tag, BOB))
    await asyncio.sleep(0)
    held.give(EVE, "eve took control over")
    slow.waiting[0][1].set_result(None)
    with pytest.raises(CommandRefused, match="changed meanwhile"):
        await taking
    assert held.holder == EVE


async def test_control_is_not_handed_on_by_who_lost_it_meanwhile_nor_to_a_page_that_was_closed() -> None:
    held, slow, here = OperatorLease(), Slow(), [ANN, BOB, EVE]
    people: Any = PeopleHere(lambda: here, held, slow, permits_of(held), EventLog())  # type: ignore[arg-type]
    held.acquire(ANN)
    giving = asyncio.create_task(people.hand_over(BOB.tag, ANN))
    await asyncio.sleep(0)
    held.give(EVE, "eve took control over")
    slow.waiting[0][1].set_result(None)
    with pytest.raises(NotAllowed):
        await giving
    giving = asyncio.create_task(people.hand_over(BOB.tag, EVE))
    await asyncio.sleep(0)
    here.remove(BOB)
    slow.waiting[1][1].set_result(None)
    with pytest.raises(CommandRefused, match="page open"):
        await giving
    assert held.holder == EVE
