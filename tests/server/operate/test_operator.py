"""What the sender thread makes of requests, targets and settings, in which order."""

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from functools import partial

import numpy as np
import pytest

from controller.errors import CommandRefused, RigUnreachable, SessionUnknown
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, CommandReply, Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import Settings
from server.access.permit import Permit
from server.http.who import Identity
from server.operate.operator import Operator
from server.operate.stopper import Stopper
from tests.server.leave import ANYTHING

ANN = Identity("a", "ann", "operator")


class Loop:
    """Stands in for the rig: keeps every command, answers when the gate is open."""

    def __init__(self) -> None:
        self.heard: list[Command] = []
        self.stops: list[int] = []
        self.boots: list[int] = []
        self.pressed: list[str] = []
        self.gate = threading.Event()
        self.gate.set()
        self.stalled = threading.Event()
        self.arrived = threading.Semaphore(0)
        self.accepts = True
        self.answers = True
        self.shows = True
        """What it took is in its newest row at once."""
        self.boot: int | None = 7
        self.row = np.zeros(1, record_dtype(Telemetry))

    def send(self, command: Command) -> CommandReply:
        self.heard.append(command)
        self.arrived.release()
        if not self.gate.is_set():
            self.stalled.set()
            self.gate.wait()
        if not self.answers:
            raise RigUnreachable("no answer")
        if self.accepts and self.shows:
            self.row["request_n"] = max(self.row["request_n"][0], command.request_n)
        return CommandReply(n=command.n, accepted=self.accepts, mode=Mode.HOLD, cause=Cause.NONE, detail="")

    def stop(self, number: int, boot: int, by: str) -> CommandReply:
        """By its own lane: a stalled call does not stand in its way."""
        self.stops.append(number)
        self.boots.append(boot)
        self.pressed.append(by)
        if not self.answers:
            raise RigUnreachable("no answer")
        self.row["request_n"] = taken = (
            max(self.row["request_n"][0], max((c.request_n for c in self.heard), default=0)) + 100
        )
        return CommandReply(n=int(taken), accepted=True, mode=Mode.E_STOP, cause=Cause.NONE, detail="")

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
    stopper = Stopper(loop.stop, lambda: loop.boot)
    found = Operator(loop.send, lambda: loop.boot, lambda: loop.row, Settings(), stopper)
    yield found
    loop.gate.set()
    found.close()


def test_repetition_neither_asks_nor_shows_presence_nor_moves(loop: Loop, operator: Operator) -> None:
    """A server that starts beside a moving rig numbers on, and its heartbeat changes nothing."""
    loop.row["request_n"], loop.row["presence"], loop.row["target"] = 41, 900, (0.1, 0.2)
    loop.boot = 8
    operator.request(Request.ARM, ANYTHING).result(20)
    first = next(command for command in loop.heard if command.boot == 8)
    assert (first.presence, first.target, first.request_n) == (900, (0.1, 0.2), 41 + (first.request == Request.ARM))
    for _ in range(3):
        loop.hear()
    later = loop.hear()
    assert (later.request, later.request_n, later.presence) == (Request.NONE, 42, 900)
    operator.present(ANYTHING)
    operator.move((0.0, 0.1), ANYTHING).result(20)
    assert loop.heard[-1].presence == 901


def test_a_request_is_answered_when_the_row_that_shows_it_has_come(loop: Loop, operator: Operator) -> None:
    """Who is answered may ask for a run at once: what the server knows of the rig is then no older than the answer."""
    loop.shows = False
    asked = operator.request(Request.ARM, ANYTHING)
    assert operator.move((0.0, 0.1), ANYTHING).result(20).accepted, "what asks for no mode is answered meanwhile"
    assert not asked.done()
    heard = len(loop.heard)
    loop.row["request_n"] = 1
    assert asked.result(20).accepted
    assert len(loop.heard) - heard < 5, "to look for the row is no reason to send"
    loop.accepts = False
    assert not operator.request(Request.ARM, ANYTHING).result(20).accepted, "a refusal changes nothing to see"
    loop.accepts, loop.boot = True, 8
    second = operator.request(Request.ARM, ANYTHING)
    assert second.result(20).accepted, "a rig that shows nothing delays its answer, and no more"


def test_a_sign_of_the_operator_rises_above_what_another_server_sent(loop: Loop, operator: Operator) -> None:
    loop.row["presence"] = 5000
    operator.move((0.0, 0.1), ANYTHING).result(20)
    assert loop.heard[-1].presence == 0, "without a sign nothing rises"
    operator.present(ANYTHING)
    operator.move((0.0, 0.2), ANYTHING).result(20)
    assert loop.heard[-1].presence == 5001


def test_targets_are_newest_wins_and_everyone_is_answered(loop: Loop, operator: Operator) -> None:
    loop.stall()
    waiting = [operator.move((i / 100, 0.0), ANYTHING) for i in range(50)]
    loop.gate.set()
    replies = {asked.result(20).n for asked in waiting}
    assert len(replies) == 1
    targets = [command.target for command in loop.heard if command.target != (0.0, 0.0)]
    assert set(targets) == {(0.49, 0.0)}


def test_requests_keep_their_order_and_a_later_move_does_not_pass_them(loop: Loop, operator: Operator) -> None:
    before = loop.stall()
    asked: list[Future[CommandReply]] = [
        operator.request(Request.ARM, ANYTHING),
        operator.request(Request.FOLLOW, ANYTHING, (0.3, 0.0)),
        operator.move((0.4, 0.0), ANYTHING),
    ]
    loop.gate.set()
    wait(asked, 20)
    seen = [(c.request, c.target[0]) for c in loop.heard[before : before + 3]]
    assert seen == [(Request.ARM, 0.0), (Request.FOLLOW, 0.3), (Request.NONE, 0.4)]
    numbers = [c.request_n for c in loop.heard if c.request]
    assert numbers == sorted(set(numbers)), "each request has a number of its own"


@pytest.mark.parametrize("ends", [Request.HOLD, Request.REST])
def test_what_ends_motion_drops_what_waits_and_would_move(ends: Request, loop: Loop, operator: Operator) -> None:
    """A FOLLOW of the socket that was read before a HOLD by HTTP must not move the rig first, nor after."""
    before = loop.stall()
    dropped = [
        operator.request(Request.FOLLOW, ANYTHING, (0.1, 0.0)),
        operator.move((0.2, 0.0), ANYTHING),
        operator.request(Request.TRACK, ANYTHING),
    ]
    kept = [operator.change(Settings(K_P=(1.0, 1.0)), ANYTHING), operator.request(ends, ANYTHING)]
    later = operator.request(Request.FOLLOW, ANYTHING, (0.3, 0.0))
    loop.gate.set()
    for one in dropped:
        with pytest.raises(CommandRefused, match=f"overtaken by {ends.name}"):
            one.result(20)
    assert all(one.result(20).accepted for one in [*kept, later])
    seen = [(c.request, c.target[0]) for c in loop.heard[before:] if c.request or c.target[0]]
    assert seen[:2] == [(ends, 0.0), (Request.FOLLOW, 0.3)]


def test_what_the_last_operator_began_is_held_and_what_the_new_one_began_goes_on(
    loop: Loop, operator: Operator
) -> None:
    """However late the hand-over is seen: before the new operator's press leaves, between, or after it."""
    lost = [""]
    old = Permit(ANN, lambda request: lost[0])
    assert operator.request(Request.FOLLOW, old, (0.1, 0.0)).result(20).accepted
    lost[0] = "only the operator may do this"
    operator.hold_left()
    wait_until(lambda: loop.heard[-1].request == Request.NONE and loop.heard[-2].request == Request.HOLD)
    before = loop.stall()
    waiting = operator.request(Request.FOLLOW, ANYTHING, (0.2, 0.0))
    operator.hold_left()
    loop.gate.set()
    assert waiting.result(20).accepted
    operator.hold_left()
    assert operator.move((0.3, 0.0), ANYTHING).result(20).accepted
    assert [c.request for c in loop.heard[before:] if c.request] == [Request.FOLLOW]


def test_e_stop_waits_for_no_call_and_ends_what_waits(loop: Loop, operator: Operator) -> None:
    loop.stall()
    clear, arm = operator.request(Request.CLEAR, ANYTHING), operator.request(Request.ARM, ANYTHING)
    assert operator.stop().result(20).mode == Mode.E_STOP, "while a call of the operator's is not answered"
    for overtaken in (clear, arm):
        with pytest.raises(CommandRefused, match="overtaken by an E-STOP"):
            overtaken.result(20)
    loop.gate.set()
    assert operator.request(Request.CLEAR, ANYTHING).result(20).accepted
    cleared = next(command for command in loop.heard if command.request == Request.CLEAR)
    assert cleared.request_n > 100, "above the number that the E-STOP took, seen in a row or not"


def test_an_e_stop_leaves_before_any_other_thread_has_its_turn_and_has_one_number(loop: Loop) -> None:
    """It is on its way when `stop` returns, also while the thread that waits for the answer is busy."""
    at_once, answered = list[tuple[int, int, str]](), threading.Event()
    fails: list[Exception] = []

    def sent(number: int, boot: int, by: str) -> Callable[[], CommandReply] | None:
        at_once.append((number, boot, by))
        return None if by == "eve" else partial(late, number, boot, by)

    def late(number: int, boot: int, by: str) -> CommandReply:
        answered.wait(20)
        if fails:
            raise fails.pop()
        return CommandReply(n=number, accepted=True, mode=Mode.E_STOP, cause=Cause.NONE, detail="")

    stopper = Stopper(loop.stop, lambda: loop.boot, sent)
    try:
        first = stopper.stop("ann")
        assert [one[1:] for one in at_once] == [(7, "ann")]
        answered.set()
        assert first.result(20).n == at_once[0][0]
        assert not loop.stops, "it was answered, and is not sent again"
        fails.append(SessionUnknown("of a life before"))
        stopper.stop("ann").result(20)
        assert loop.stops == [at_once[1][0]], "it is sent with the same number"
        fails.append(RigUnreachable("late"))
        with pytest.raises(RigUnreachable, match="sent again"):
            stopper.stop("ann").result(20)
        wait_until(lambda: not stopper.waits)
        assert loop.stops[1:] == [at_once[2][0]]
        stopper.over()
        assert stopper.stop("eve").result(20).accepted, "it could not leave at once"
        assert loop.stops[2:] == [at_once[3][0]]
        loop.boot = None
        stopper.stop("bob")
        assert len(at_once) == 4, "no rig was met that it could be meant for"
    finally:
        stopper.close()


def test_an_e_stop_without_an_answer_is_sent_until_there_is_one_and_nothing_else_is(
    loop: Loop, operator: Operator
) -> None:
    loop.answers = False
    with pytest.raises(RigUnreachable, match="sent again"):
        operator.stop().result(20)
    with pytest.raises(CommandRefused, match="E-STOP"):
        operator.request(Request.CLEAR, ANYTHING).result(20)
    wait_until(lambda: len(loop.stops) > 3)
    loop.answers = True
    wait_until(lambda: loop.row["request_n"][0] > 0)
    assert len(set(loop.stops)) == 1, "one press, one number: the rig acts on it once"
    wait_until(lambda: not operator.stopper.waits)
    count = len(loop.stops)
    assert operator.request(Request.CLEAR, ANYTHING).result(20).accepted
    assert len(loop.stops) == count
    operator.stop().result(20)
    assert len(set(loop.stops)) == 2


@pytest.mark.parametrize("begun", [Request.FOLLOW, Request.TRACK, Request.NONE])
def test_motion_that_was_not_answered_is_followed_by_a_hold_and_no_older_target(
    begun: Request, loop: Loop, operator: Operator
) -> None:
    """It may have been taken: then the rig moves, and no one was told."""
    operator.request(Request.FOLLOW, ANYTHING, (0.1, 0.05)).result(20)
    loop.row["mode"], loop.answers = Mode.FOLLOW, False
    asked = operator.request(begun, ANYTHING, (0.1, -0.05)) if begun else operator.move((0.1, -0.05), ANYTHING)
    with pytest.raises(RigUnreachable):
        asked.result(20)
    with pytest.raises(RigUnreachable):
        operator.move((0.2, 0.0), ANYTHING).result(20)
    loop.answers = True
    wait_until(lambda: loop.heard[-1].request == Request.NONE and loop.heard[-2].request == Request.HOLD)
    sent = next(i for i, command in enumerate(loop.heard) if command.target == (0.1, -0.05))
    after = loop.heard[sent + 1 :]
    assert {command.target for command in after} == {(0.1, -0.05)}
    assert after[0].request == Request.HOLD
    assert after[0].request_n > loop.heard[sent].request_n


def test_a_drag_goes_on_after_an_unanswered_target_only_by_a_fresh_press(loop: Loop, operator: Operator) -> None:
    operator.request(Request.FOLLOW, ANYTHING, (0.1, 0.0)).result(20)
    loop.row["mode"], loop.answers = Mode.FOLLOW, False
    with pytest.raises(RigUnreachable):
        operator.move((0.2, 0.0), ANYTHING).result(20)
    before = loop.stall()
    loop.answers = True
    moved, pressed = operator.move((0.3, 0.0), ANYTHING), operator.request(Request.FOLLOW, ANYTHING, (0.4, 0.0))
    loop.gate.set()
    assert pressed.result(20).accepted
    try:
        assert moved.result(20).accepted
    except CommandRefused as error:
        assert "begin again" in str(error)
    held = next(i for i, c in enumerate(loop.heard[before - 1 :]) if c.request == Request.HOLD)
    assert all(c.target == (0.2, 0.0) for c in loop.heard[before - 1 :][: held + 1])


def test_an_unanswered_request_uses_up_its_number(loop: Loop, operator: Operator) -> None:
    loop.answers = False
    with pytest.raises(RigUnreachable):
        operator.request(Request.ARM, ANYTHING).result(20)
    lost = max(command.request_n for command in loop.heard)
    loop.answers = True
    operator.request(Request.HOLD, ANYTHING).result(20)
    held = next(command for command in loop.heard if command.request == Request.HOLD)
    assert held.request_n == lost + 1


def test_settings_count_only_when_the_rig_took_them(loop: Loop, operator: Operator) -> None:
    loop.accepts = False
    assert not operator.change(Settings(K_P=(1.0, 1.0)), ANYTHING).result(20).accepted
    assert operator.settings == Settings()
    loop.accepts = True
    operator.change(Settings(K_P=(2.0, 2.0)), ANYTHING).result(20)
    assert operator.settings.K_P == (2.0, 2.0)
    loop.hear()


def test_a_request_for_the_life_before_is_refused_and_settings_outlive_it(loop: Loop, operator: Operator) -> None:
    operator.change(Settings(K_P=(2.0, 2.0)), ANYTHING).result(20)
    loop.stall()
    stale = operator.request(Request.ARM, ANYTHING)
    loop.boot = 9
    loop.gate.set()
    with pytest.raises(CommandRefused, match="restarted"):
        stale.result(20)
    while (last := loop.hear()).boot != 9:
        pass
    assert (last.request, last.settings.K_P) == (Request.NONE, (2.0, 2.0))


def test_what_was_asked_in_a_silence_of_the_rig_is_refused_as_that_unless_it_stills(
    loop: Loop, operator: Operator
) -> None:
    answers = []
    for request in (Request.ARM, Request.HOLD):
        loop.stall()
        loop.boot = None
        answers.append(operator.request(request, ANYTHING))
        loop.boot = 7
        loop.gate.set()
    with pytest.raises(RigUnreachable, match="silent"):
        answers[0].result(20)
    assert answers[1].result(20).accepted


def test_without_a_rig_every_asker_is_told(loop: Loop, operator: Operator) -> None:
    loop.boot = None
    for asked in (operator.stop(), operator.move((0.0, 0.0), ANYTHING), operator.change(Settings(), ANYTHING)):
        with pytest.raises(RigUnreachable):
            asked.result(20)


def test_an_e_stop_that_a_life_of_the_rig_never_answered_stops_its_next_one(loop: Loop, operator: Operator) -> None:
    """Else a rig that dies as it is stopped would come back ready to arm."""
    loop.answers = False
    with pytest.raises(RigUnreachable):
        operator.stop("Ada").result(20)
    loop.boot = 9
    assert operator.stopper.waits
    with pytest.raises(CommandRefused, match="E-STOP waits"):
        operator.request(Request.ARM, ANYTHING).result(20)
    loop.answers = True
    wait_until(lambda: not operator.stopper.waits)
    assert loop.boots[-1] == 9 and loop.pressed[-1] == "Ada"
    assert loop.stops[-1] == loop.stops[0]  # one press


def wait_until(what: Callable[[], bool]) -> None:
    """Wait until `what` is true; the heartbeat comes ten times a second."""
    end = time.monotonic() + 20
    while not what():
        assert time.monotonic() < end, "this never came true"
        time.sleep(0.005)
