"""Two servers and a rig without threads, wires or clocks: the real operator's side, link's end, handler and tick.

What stands in: the wire (it answers, loses the reply, loses the message, or delivers it later), the clock, and the
plant, whose markers stand still. A message is late by less than a second: zenoh ends a link that is silent for longer.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal, cast

import numpy as np

from controller.errors import RigUnreachable, SessionUnknown, TendrilError
from controller.link.client import QUIET_S, press
from controller.link.seal import Introduction, Sealer
from controller.realtime import command_handler as handler_module
from controller.schema.layout import to_record
from controller.schema.messages import Command, CommandReply
from controller.schema.modes import Mode, Request
from controller.schema.parameters import Settings
from controller.system.thread import SupervisedThread
from server.access.permit import Permit
from server.operate import operator as operator_module
from server.operate import stopper as stopper_module
from server.operate.job import Job
from server.operate.operator import Operator
from server.operate.stopper import Stopper
from tests.controller.desk import MS
from tests.server.protocol_rig import KEY, KEYS, Asked, Message, Rig

Fate = Literal["answered", "reply lost", "lost", "late", "stalled"]
FATES: tuple[Fate, ...] = ("answered", "reply lost", "lost", "late", "stalled")
"""The last: it is answered, but the loop stands still meanwhile."""
TIMEOUT_MS, LATEST_MS = 50, 900
SILENT_MS = 2100
"""After which another server may command."""
LONG, SELDOM = 50, 25
"""From the first on [ms] the loop ticks only every second [ms]."""
STILL = (Request.HOLD, Request.REST)
MOVING = (Mode.FOLLOW, Mode.TRACK)
ANYTHING = Permit(None, lambda request: "", sign=lambda: True)


class Lane:
    """One sealed way of a server to the rig, as `Asker` keeps it."""

    def __init__(self, world: "World") -> None:
        self.world = world
        self.sealer: Sealer | None = None

    def ask(self, key: str, payload: bytes, what: list[Asked], fate: Fate) -> bytes:
        try:
            return self._ask(key, payload, what, fate)
        except SessionUnknown:
            self.sealer = None
            return self._ask(key, payload, what, fate)

    def send(self, key: str, payload: bytes, fate: Fate | None) -> Callable[[], bytes] | None:
        """Sent by who does not wait for the answer, and opens no session; what then does."""
        if self.sealer is None or fate is None:
            return None
        message = Message(self.world.rig.boot, key, payload, self.sealer.seal(key, payload), [], self.world.now)
        answer: bytes | TendrilError = RigUnreachable("did not answer")
        if fate == "late":
            self.world.late.append(message)
        elif fate != "lost":
            try:
                heard = self.world.rig.hear(message)
                answer = answer if fate == "reply lost" else heard
            except TendrilError as error:
                answer = error
            self.world.old.append(message)
        return partial(_given, answer)

    def _ask(self, key: str, payload: bytes, what: list[Asked], fate: Fate) -> bytes:
        world = self.world
        if self.sealer is None:
            self.sealer = self._opened()
        message = Message(world.rig.boot, key, payload, self.sealer.seal(key, payload), what, world.now)
        if fate in ("answered", "reply lost", "stalled"):
            world.stalls = fate == "stalled"
            answer = world.rig.hear(message)
            world.stalls = False
            world.old.append(message)
            if fate != "reply lost":
                return answer
        elif fate == "late":
            world.late.append(message)
        world.run(TIMEOUT_MS)
        raise RigUnreachable("did not answer")

    def _opened(self) -> Sealer:
        end = self.world.rig.end
        told = end._session(b"", b"")
        sealer = Sealer(KEY, self.world.rig.boot, int.from_bytes(told[8:], "little"))
        payload = Introduction(who="a server").model_dump_json().encode()
        end._session(payload, sealer.seal(KEYS.session, payload))
        return sealer


def _given(answer: bytes | TendrilError) -> bytes:
    if isinstance(answer, TendrilError):
        raise answer
    return answer


class Unthreaded:
    """In the place of a worker: it is stepped by hand."""

    def __init__(self, *given: Any, **more: Any) -> None:
        pass

    def start(self) -> None:
        """Nothing is begun."""


class Server:
    """Operator and stopper of one server, stepped by hand; `row` is the newest row that reached it."""

    def __init__(self, world: "World") -> None:
        self.world, self.fate = world, cast(Fate, "answered")
        self.boot, self.row, self.seen = world.rig.boot, world.rig.telemetry.copy(), world.now
        self.commands, self.stops = Lane(world), Lane(world)
        self.serving: list[Asked] = []
        self.pressed_within = False
        """E-STOP is pressed, and answered, while the next record is on its way."""
        self.at_once: Fate | None = None
        """What becomes of an E-STOP that leaves before the stopper's thread has its turn; None: it could not."""
        self.stopper = Stopper(self._stop, lambda: self.boot, self._send_stop)
        self.operator = Operator(self._send, self.hears, lambda: self.row, Settings(), self.stopper)

    def see(self) -> None:
        """Telemetry comes, of whatever boot is there now."""
        if self.boot != self.world.rig.boot:
            self.boot = self.world.rig.boot
            self.commands.sealer = self.stops.sealer = None
        self.row, self.seen = self.world.rig.telemetry.copy(), self.world.now

    def hears(self) -> int | None:
        """The boot whose rows come; None where they do not."""
        return self.boot if self.world.now - self.seen < QUIET_S * 1000 * MS else None

    def step(self, fate: Fate) -> None:
        """One turn of the operator's thread: a job, or a repetition."""
        operator, self.fate = self.operator, fate
        job = operator._jobs.popleft() if operator._jobs else Job()
        self.serving = [one for one in self.world.asked if one.answer in job.askers]
        operator._serve(job)
        operator.acknowledgements.look(all_of_them=True)  # as late as an answer comes: without the row that shows it

    def step_stop(self, fate: Fate) -> None:
        """One turn of the stopper's thread."""
        stopper, self.fate = self.stopper, fate
        answers, stopper._asked = stopper._asked, []
        if answers:
            stopper._begin()
        if answers or stopper._waiting:
            stopper._serve(answers)

    def _send(self, command: Command) -> CommandReply:
        what = [one for one in self.serving if command.request in (one.request, Request.NONE)]
        answer = self.commands.ask(KEYS.command, to_record(command).tobytes(), what, self.fate)
        if self.pressed_within:
            self.pressed_within = False
            self.world.press(self)
            self.step_stop("answered")
        return CommandReply.model_validate_json(answer)

    def _send_stop(self, number: int, boot: int, by: str) -> Callable[[], CommandReply] | None:
        answer = self.stops.send(KEYS.stop, press(number, boot, by), self.at_once)
        return None if answer is None else lambda: CommandReply.model_validate_json(answer())

    def _stop(self, number: int, boot: int, by: str) -> CommandReply:
        answer = self.stops.ask(KEYS.stop, press(number, boot, by), [], self.fate)
        return CommandReply.model_validate_json(answer)


@dataclass(repr=False)
class World:
    """Everything, and the judge of every tick."""

    folder: Path
    now: int = 10_000 * MS
    boots: int = 0
    asked: list[Asked] = field(default_factory=list)
    pressed: list[Asked] = field(default_factory=list)
    late: list[Message] = field(default_factory=list)
    old: list[Message] = field(default_factory=list)
    delivered: list[Message] = field(default_factory=list)
    stopped_since: list[int] = field(default_factory=list)
    """Ticks at which the loop took an E-STOP, in this boot: the order of what was asked by then."""
    order: int = 0
    followed: int = 0
    """Order of the target that is in force."""
    wrong: list[AssertionError] = field(default_factory=list)
    stalls: bool = False
    """The loop stands still."""
    by: Asked | None = None
    """What began the motion that is under way."""

    def __post_init__(self) -> None:
        for module in (operator_module, stopper_module):
            module.SupervisedThread = Unthreaded  # type: ignore[misc, assignment]
        handler_module.time = SimpleNamespace(monotonic_ns=lambda: self.now, sleep=lambda seconds: self.run(1))  # type: ignore[assignment]
        self.restart()
        self.servers = [Server(self), Server(self)]

    def restart(self) -> None:
        """Another boot of the rig."""
        self.boots += 1
        for one in self.pressed:
            one.carried = not one.said
        self.stopped_since, self.followed, self.by = [], 0, None
        self.rig = Rig(self, self.boots)
        self.run(30)

    def run(self, milliseconds: int) -> None:
        """Let the loop tick; where that is long only as often as it must, or it would have stood still."""
        step = SELDOM if milliseconds >= LONG else 1
        for _ in range(0, milliseconds, step):
            self.now += step * MS
            if not self.stalls:
                self.rig.tick()
        self.late = [one for one in self.late if self.now - one.sent_ns < LATEST_MS * MS]

    def ask(self, server: Server, request: Request) -> None:
        """Someone at `server` asks; every target is another one, and says by its place when it was asked for."""
        self.order += 1
        at = (0.2, self.order * 1e-5)
        if request == Request.NONE:
            answer = server.operator.move(at, ANYTHING)
        else:
            answer = server.operator.request(request, ANYTHING, at if request == Request.FOLLOW else None)
        self.asked.append(Asked(self.order, request, server.boot, server, answer))

    def press(self, server: Server, at_once: Fate | None = None) -> None:
        """E-STOP."""
        server.at_once = at_once
        self.order += 1
        pressed = Asked(self.order, Request.E_STOP, server.boot, server, Future())
        pressed.carried = server.boot != self.rig.boot
        self.pressed.append(pressed)  # before it leaves: the rig may act on it at once
        pressed.answer = server.operator.stop()
        assert not server.operator._jobs, "something waits though an E-STOP was pressed"

    def deliver(self, index: int, again: bool) -> None:
        """A late message arrives, or one that arrived before comes once more."""
        messages = self.old if again else self.late
        if messages:
            message = messages[-1 - index % len(messages)] if again else messages.pop(index % len(messages))
            if not again:
                self.old.append(message)
            try:
                self.rig.hear(message)
            except TendrilError:
                return  # the sender does not hear it any more

    def judge(self, before: np.void, row: np.void) -> None:
        """Look at one tick. What is wrong is kept: raised here, a server would take it for a failure of its wire."""
        try:
            self._judge(before, row)
        except AssertionError as error:
            self.wrong.append(error)

    def _judge(self, before: np.void, row: np.void) -> None:
        if row["request_n"] != before["request_n"] and row["request_cause"] == 0:
            self._taken(Request(int(self.rig.command["request"][0])))
        if row["mode"] == Mode.FOLLOW and self.order:
            target = round(float(row["target"][1]) * 1e5)
            assert target >= self.followed, f"target {target} after the newer {self.followed}"
            self.followed = target

    def _taken(self, request: Request) -> None:
        if request == Request.E_STOP:
            here = self._pressed_for_now()
            assert here, "an E-STOP for another boot"
            assert len(self.stopped_since) < len(here), "an E-STOP was acted on twice"
            self.stopped_since.append(max((one.order for one in self.pressed), default=0))
            return
        if request == Request.NONE:
            return  # a repetition says that the numbers up to here are used up
        message = self.delivered[-1]
        whose = next((one for one in message.what if one.request == request), None)
        if whose is None:
            unsure = any(one.moves and one.answer.done() and not one.said for one in self.asked)
            assert request == Request.HOLD and unsure, f"no one asked for {request.name}"
            return
        whose.taken += 1
        assert whose.taken == 1, f"{whose} was acted on twice"
        assert whose.boot == self.rig.boot, f"{whose} was for another boot"
        assert all(whose.order > stop for stop in self.stopped_since), f"{whose} was asked before an E-STOP"
        mine = [one.order for one in self.pressed if one.server is whose.server and one.boot == whose.boot]
        before = max((order for order in mine if order < whose.order), default=0)
        assert before <= max(self.stopped_since, default=0), f"{whose} passes an E-STOP that waits"
        if request in (Request.FOLLOW, Request.TRACK):
            self.by = whose
            ended = [one for one in self.asked if one.request in STILL and one.said and one.boot == self.rig.boot]
            assert all(whose.order > one.order for one in ended), f"{whose} moves after {ended[-1]}"

    def _pressed_for_now(self) -> list[Asked]:
        """The E-STOPs that this boot of the rig has to take."""
        return [one for one in self.pressed if one.boot == self.rig.boot or one.carried]

    def settle(self) -> None:
        """The wire works again: everything is answered."""
        self.late.clear()
        for server in self.servers:
            server.pressed_within = False
        for _ in range(6):
            for server in self.servers:
                server.see()
                server.step_stop("answered")
                server.step("answered")
            self.run(3)

    def restore(self) -> None:
        """The modules as they were."""
        operator_module.SupervisedThread = stopper_module.SupervisedThread = SupervisedThread  # type: ignore[misc]
        handler_module.time = time

    def close(self) -> None:
        """What must hold in the end."""
        try:
            self.settle()
            self._judge_end()
            self.work()
        finally:
            self.restore()

    def work(self) -> None:
        """A server that may command gets what it asks for, though no row tells it of the last."""
        server, holder = self.servers[0], self.rig.end._holder._session
        if not (holder and server.commands.sealer and holder.number == server.commands.sealer.session):
            self.run(SILENT_MS)
        server.see()
        self.press(server)
        server.step_stop("answered")
        self._require_taken(self.pressed[-1])
        server.operator.present(ANYTHING)
        for request in (Request.CLEAR, Request.ARM, Request.FOLLOW, Request.NONE, Request.HOLD):
            self.ask(server, request)
            server.step("answered")
            self._require_taken(self.asked[-1])
            assert request != Request.NONE or self.followed == self.order, "the target does not move"

    def _require_taken(self, one: Asked) -> None:
        self._raise_wrong()
        assert one.answer.done() and one.said, f"{one} was not taken: {one.answer}"

    def _raise_wrong(self) -> None:
        if self.wrong:
            raise self.wrong[0]

    def _judge_end(self) -> None:
        self._raise_wrong()
        for one in [*self.asked, *self.pressed]:
            assert one.answer.done(), f"{one} was never answered"
        here = [one for one in self.asked if one.boot == self.rig.boot and one.request != Request.NONE]
        for one in here:
            assert one.said is None or one.said == bool(one.taken), f"{one} was told something else"
        if pressed := self._pressed_for_now():
            assert max(self.stopped_since, default=0) >= pressed[-1].order, "the last E-STOP never came into force"
        mode = Mode(int(self.rig.telemetry["mode"][0]))
        if mode in MOVING:
            assert self.by is not None and self.by.said, f"{self.by} moves the rig, and no one was told"
        if mode == Mode.FOLLOW:
            newest = next(one for one in self.asked if one.order == self.followed)
            assert newest.said, f"{newest} is where the rig goes, and no one was told"
