"""The operator's side of the rig: one whole, numbered command, and the one thread that sends it.

Requests go in order, moved targets newest-wins while a call is under way, and the record is repeated every 100 ms so
that the rig knows the server is alive. A repetition carries no request and the same presence: it can keep nothing
moving and arm nothing. Only an E-STOP that was not answered is repeated until it is, in the same life of the rig.
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from controller.errors import CommandRefused, RigHeld, RigUnreachable, TendrilError
from controller.messages import Command, CommandReply
from controller.modes import Request
from controller.parameters import Settings
from server.channels import Rows

REPEAT = 0.1
"""Seconds between repetitions of the command."""

Target = tuple[float, float]


@dataclass
class Job:
    """Fields to change in the command, and everyone who waits for the rig's answer to it."""

    request: Request = Request.NONE
    target: Target | None = None
    settings: Settings | None = None
    life: int | None = None
    """Boot id of the rig that the asker saw."""
    askers: list["Future[CommandReply]"] = field(default_factory=list)

    @property
    def moves_only(self) -> bool:
        """A newer target may take this job's place."""
        return self.request == Request.NONE and self.settings is None

    def fail(self, error: TendrilError) -> None:
        """Tell every asker that the command did not go out, or was not answered."""
        for asker in self.askers:
            asker.set_exception(error)


class Operator:
    """Sends the desired command to the rig and resolves each asker's future with the rig's reply.

    `send` is the blocking call to the rig, `boot` the life of the rig that is connected (None: not connected), `newest`
    its newest telemetry row: numbers go on from what the rig echoes, so nobody's restart can repeat a request.
    """

    def __init__(
        self,
        send: Callable[[Command], CommandReply],
        boot: Callable[[], int | None],
        newest: Callable[[], Rows | None],
        settings: Settings,
    ) -> None:
        self._send, self._boot, self._newest = send, boot, newest
        self._command = Command(settings=settings)
        self._life: int | None = None
        self._jobs: deque[Job] = deque()
        self._wake = threading.Condition()
        self._present = 0
        self._leaving = self._closed = False
        self._thread = threading.Thread(target=self._run, name="operator", daemon=True)
        self._thread.start()

    @property
    def settings(self) -> Settings:
        """The settings that the rig has accepted."""
        return self._command.settings

    def request(self, request: Request, target: Target | None = None) -> "Future[CommandReply]":
        """Ask for another mode. E_STOP overtakes everything that waits, and ends it."""
        return self._ask(Job(request=request, target=target))

    def move(self, target: Target) -> "Future[CommandReply]":
        """Move the live target; while a call is under way only the newest one is kept, and answers for all."""
        return self._ask(Job(target=target))

    def change(self, settings: Settings) -> "Future[CommandReply]":
        """Put other settings in force; they are kept only when the rig accepts them."""
        return self._ask(Job(settings=settings))

    def present(self) -> None:
        """The operator's own page gave a fresh sign: the next command says so."""
        with self._wake:
            self._present += 1

    def leave(self) -> None:
        """Take nothing more but REST and E_STOP: this server is about to end."""
        self._leaving = True

    def close(self) -> None:
        """Stop sending; the rig then holds, and later rests, by itself."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        self._thread.join()

    def _ask(self, job: Job) -> "Future[CommandReply]":
        asker: Future[CommandReply] = Future()
        asker.set_running_or_notify_cancel()
        job.askers.append(asker)
        job.life = self._boot()
        with self._wake:
            if self._closed:
                job.fail(RigUnreachable("the server is shutting down"))
            elif self._leaving and job.request not in (Request.REST, Request.E_STOP):
                job.fail(CommandRefused("refused: the server is shutting down, and the rig comes to rest"))
            elif job.request == Request.E_STOP:
                self._drop(CommandRefused("overtaken by an E-STOP"))
                self._jobs.append(job)
            elif job.moves_only and self._jobs and self._jobs[-1].moves_only:
                self._jobs[-1].target = job.target
                self._jobs[-1].askers += job.askers
            else:
                self._jobs.append(job)
            self._wake.notify()
        return asker

    def _drop(self, error: TendrilError) -> None:
        while self._jobs:
            self._jobs.popleft().fail(error)

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._jobs or self._closed, max(0.0, due - time.monotonic()))
                if self._closed:
                    return self._drop(RigUnreachable("the server is shutting down"))
                job = self._jobs.popleft() if self._jobs else Job()
            due = time.monotonic() + REPEAT
            self._serve(job)

    def _serve(self, job: Job) -> None:
        try:
            reply = self._call(job)
        except TendrilError as error:
            return job.fail(error)
        except Exception as error:  # the heartbeat must outlive any failure of one call
            return job.fail(RigUnreachable(f"the command could not be sent: {error}"))
        for asker in job.askers:
            asker.set_result(reply)

    def _call(self, job: Job) -> CommandReply:
        newest = self._follow_life(job)
        command = self._next(job, newest)
        # Until the rig has taken it, the next record must not carry the change; its numbers are used up all the same.
        numbers = {"n": command.n, "request_n": command.request_n, "presence": command.presence}
        unanswered = command.request if command.request == Request.E_STOP else Request.NONE
        self._command = self._command.model_copy(update={**numbers, "request": unanswered})
        try:
            reply = self._send(command)
        except RigHeld:
            self._life = None  # what the other server does to target and numbers is read before we command again
            raise
        if reply.accepted:
            self._command = command.model_copy(update={"request": Request.NONE})
        return reply

    def _next(self, job: Job, newest: Any) -> Command:
        last, presence = self._command, self._command.presence
        with self._wake:
            signs, self._present = self._present, 0
        if signs:  # the rig takes only a number above all that it has seen, whoever sent them
            presence = max(presence, int(newest["presence"])) + signs
        changes: dict[str, Any] = {"n": last.n + 1, "presence": presence}
        if job.request != Request.NONE:
            request_n = max(last.request_n, int(newest["request_n"])) + 1
            changes |= {"request": job.request, "request_n": request_n}
        elif last.request == Request.E_STOP and newest["request_n"] > last.request_n:
            changes["request_n"] = int(newest["request_n"]) + 1  # it waited, and another server asked meanwhile
        if job.target is not None:
            changes["target"] = job.target
        if job.settings is not None:
            changes["settings"] = job.settings
        return last.model_copy(update=changes)

    def _follow_life(self, job: Job) -> Any:
        """The newest row of the life that is connected; in a new life, number on from what it echoes.

        Settings outlive a restart of the rig; requests and targets do not.
        """
        life, newest = self._boot(), self._newest()
        if life is None or newest is None:
            if job.request == Request.E_STOP:
                self._keep_stop()
            raise RigUnreachable("the rig does not answer")
        if life != self._life:
            self._command = _resume(newest[0], life, self._command.settings)
            self._life = life
        if job.request not in (Request.NONE, Request.E_STOP):
            if job.life != life:
                raise CommandRefused("the rig restarted since this was asked for")
            if self._command.request == Request.E_STOP:
                raise CommandRefused("an E-STOP waits for the rig's answer")
        return newest[0]

    def _keep_stop(self) -> None:
        """Let the next record that reaches the same life of the rig carry this E-STOP; another life starts vented."""
        last = self._command
        self._command = last.model_copy(update={"request": Request.E_STOP, "request_n": last.request_n + 1})


def _resume(row: Any, life: int, settings: Settings) -> Command:
    """The command that changes nothing in this life of the rig but the settings."""
    return Command(
        n=int(row["command_n"]),
        request_n=int(row["request_n"]),
        presence=int(row["presence"]),
        boot=life,
        target=(float(row["target"][0]), float(row["target"][1])),
        settings=settings,
    )
