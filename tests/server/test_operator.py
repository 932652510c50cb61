"""What the sender thread makes of requests, targets and settings, in which order."""

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait

import numpy as np
import pytest

from controller.errors import CommandRefused, RigUnreachable
from controller.layout import record_dtype
from controller.messages import Command, CommandReply, Telemetry
from controller.modes import Cause, Mode, Request
from controller.parameters import Settings
from server.operator import Operator


class Loop:
    """Stands in for the rig: keeps every command, answers when the gate is open."""

    def __init__(self) -> None:
        self.heard: list[Command] = []
        self.gate = threading.Event()
        self.gate.set()
        self.stalled = threading.Event()
        self.arrived = threading.Semaphore(0)
        self.accepts = True
        self.answers = True
        self.life: int | None = 7
        self.row = np.zeros(1, record_dtype(Telemetry))

    def send(self, command: Command) -> CommandReply:
        self.heard.append(command)
        self.arrived.release()
        if not self.gate.is_set():
            self.stalled.set()
            self.gate.wait()
        if not self.answers:
            raise RigUnreachable("no answer")
        return CommandReply(n=command.n, accepted=self.accepts, mode=Mode.HOLD, cause=Cause.NONE, detail="")

    def stall(self) -> int:
        """Answer no more until the gate is opened; how many commands it had heard when one waits there."""
        self.stalled.clear()
        self.gate.clear()
        assert self.stalled.wait(20)
        return len(self.heard)

    def hear(self) -> Command:
        """Wait for the next command."""
        assert self.arrived.acquire(timeout=20)
        return self.heard[-1]


@pytest.fixture
def loop() -> Loop:
    return Loop()


@pytest.fixture
def operator(loop: Loop) -> Iterator[Operator]:
    found = Operator(loop.send, lambda: loop.life, lambda: loop.row, Settings())
    yield found
    loop.gate.set()
    found.close()


def test_repetition_neither_asks_nor_shows_presence_nor_moves(loop: Loop, operator: Operator) -> None:
    """A server that starts beside a moving rig numbers on, and its heartbeat changes nothing."""
    loop.row["request_n"], loop.row["presence"], loop.row["target"] = 41, 900, (0.1, 0.2)
    loop.life = 8
    operator.request(Request.ARM).result(20)
    first = next(command for command in loop.heard if command.boot == 8)
    assert (first.presence, first.target, first.request_n) == (900, (0.1, 0.2), 41 + (first.request == Request.ARM))
    for _ in range(3):
        loop.hear()
    later = loop.hear()
    assert (later.request, later.request_n, later.presence) == (Request.NONE, 42, 900)
    operator.present()
    operator.move((0.0, 0.1)).result(20)
    assert loop.heard[-1].presence == 901


def test_a_sign_of_the_operator_rises_above_what_another_server_sent(loop: Loop, operator: Operator) -> None:
    loop.row["presence"] = 5000
    operator.move((0.0, 0.1)).result(20)
    assert loop.heard[-1].presence == 0, "without a sign nothing rises"
    operator.present()
    operator.move((0.0, 0.2)).result(20)
    assert loop.heard[-1].presence == 5001


def test_targets_are_newest_wins_and_everyone_is_answered(loop: Loop, operator: Operator) -> None:
    loop.stall()
    waiting = [operator.move((i / 100, 0.0)) for i in range(50)]
    loop.gate.set()
    replies = {asked.result(20).n for asked in waiting}
    assert len(replies) == 1
    targets = [command.target for command in loop.heard if command.target != (0.0, 0.0)]
    assert set(targets) == {(0.49, 0.0)}


def test_requests_keep_their_order_and_a_later_move_does_not_pass_them(loop: Loop, operator: Operator) -> None:
    before = loop.stall()
    asked: list[Future[CommandReply]] = [
        operator.request(Request.FOLLOW, (0.1, 0.0)),
        operator.move((0.2, 0.0)),
        operator.request(Request.HOLD),
        operator.request(Request.FOLLOW, (0.3, 0.0)),
        operator.move((0.4, 0.0)),
    ]
    loop.gate.set()
    wait(asked, 20)
    seen = [(c.request, c.target[0]) for c in loop.heard[before : before + 5]]
    follow, none, hold = Request.FOLLOW, Request.NONE, Request.HOLD
    assert seen == [(follow, 0.1), (none, 0.2), (hold, 0.2), (follow, 0.3), (none, 0.4)]
    numbers = [c.request_n for c in loop.heard if c.request]
    assert numbers == sorted(set(numbers)), "each request has a number of its own"


def test_e_stop_overtakes_what_waits_and_is_repeated_until_answered(loop: Loop, operator: Operator) -> None:
    loop.stall()
    clear, arm = operator.request(Request.CLEAR), operator.request(Request.ARM)
    loop.answers = False
    stop = operator.request(Request.E_STOP)
    loop.gate.set()
    for overtaken in (clear, arm):
        with pytest.raises(CommandRefused):
            overtaken.result(20)
    with pytest.raises(RigUnreachable):
        stop.result(20)
    with pytest.raises(CommandRefused, match="E-STOP"):
        operator.request(Request.CLEAR).result(20)
    number = loop.heard[-1].request_n
    loop.answers = True
    while (last := loop.hear()).request != Request.NONE:
        assert (last.request, last.request_n) == (Request.E_STOP, number)
    assert operator.request(Request.CLEAR).result(20).accepted


def test_an_unanswered_request_uses_up_its_number(loop: Loop, operator: Operator) -> None:
    loop.answers = False
    with pytest.raises(RigUnreachable):
        operator.request(Request.ARM).result(20)
    lost = max(command.request_n for command in loop.heard)
    loop.answers = True
    operator.request(Request.HOLD).result(20)
    held = next(command for command in loop.heard if command.request == Request.HOLD)
    assert held.request_n == lost + 1


def test_settings_count_only_when_the_rig_took_them(loop: Loop, operator: Operator) -> None:
    loop.accepts = False
    assert not operator.change(Settings(K_P=(1.0, 1.0))).result(20).accepted
    assert operator.settings == Settings()
    loop.accepts = True
    operator.change(Settings(K_P=(2.0, 2.0))).result(20)
    assert operator.settings.K_P == (2.0, 2.0)
    loop.hear()


def test_a_request_for_the_life_before_is_refused_and_settings_outlive_it(loop: Loop, operator: Operator) -> None:
    operator.change(Settings(K_P=(2.0, 2.0))).result(20)
    loop.stall()
    stale = operator.request(Request.ARM)
    loop.life = 9
    loop.gate.set()
    with pytest.raises(CommandRefused, match="restarted"):
        stale.result(20)
    while (last := loop.hear()).boot != 9:
        pass
    assert (last.request, last.settings.K_P) == (Request.NONE, (2.0, 2.0))


def test_without_a_rig_every_asker_is_told(loop: Loop, operator: Operator) -> None:
    loop.life = None
    for asked in (operator.request(Request.E_STOP), operator.move((0.0, 0.0)), operator.change(Settings())):
        with pytest.raises(RigUnreachable):
            asked.result(20)


@pytest.mark.parametrize("seen", [0, 99])
def test_an_e_stop_while_the_link_is_gone_acts_when_it_is_back(seen: int, loop: Loop, operator: Operator) -> None:
    """Even if the rig has `seen` later requests of another server meanwhile."""
    operator.request(Request.ARM).result(20)
    armed, life = loop.heard[-1].request_n, loop.life
    loop.life = None
    with pytest.raises(RigUnreachable):
        operator.request(Request.E_STOP).result(20)
    before = len(loop.heard)
    loop.row["request_n"] = seen
    loop.life = life
    wait_until(lambda: len(loop.heard) > before + 1)
    stop, after = loop.heard[before : before + 2]
    assert (stop.request, stop.request_n) == (Request.E_STOP, max(armed, seen) + 1)
    assert after.request == Request.NONE, "it was answered"


def test_an_e_stop_for_a_life_that_ended_is_forgotten(loop: Loop, operator: Operator) -> None:
    operator.request(Request.ARM).result(20)
    loop.life = None
    with pytest.raises(RigUnreachable):
        operator.request(Request.E_STOP).result(20)
    before = len(loop.heard)
    loop.life = 9
    wait_until(lambda: len(loop.heard) > before + 1)
    assert {command.request for command in loop.heard[before:]} == {Request.NONE}


def wait_until(what: Callable[[], bool]) -> None:
    """Wait until `what` is true; the heartbeat comes ten times a second."""
    end = time.monotonic() + 20
    while not what():
        assert time.monotonic() < end, "this never came true"
        time.sleep(0.005)
