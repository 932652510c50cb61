"""The operator's side of the rig: one whole, numbered command, and the one thread that sends it.

Requests go in order, moved targets newest-wins while a call is under way, and the record is repeated every 100 ms so
that the rig knows the server is alive. A request is answered when the server has heard the row that shows it
(`server/operate/job.py`). A repetition carries no request and the same presence: it can keep nothing
moving and arm nothing. Whether the asker may is looked at right before its record is sent. HOLD and REST drop what
waits and would move the rig; an E-STOP has a lane of its own (`server/operate/stopper.py`) and drops everything.

What became of a record that was not answered is not known: what would have moved the rig is followed by a HOLD, so
that no motion goes on without its asker being told (docs/protocol.md).
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Annotated, Any

from controller.arrays import Rows
from controller.errors import (
    CommandRefused,
    KeyRefused,
    LayoutMismatch,
    ParameterError,
    RigHeld,
    RigUnreachable,
    TendrilError,
)
from controller.schema.messages import Command, CommandReply
from controller.schema.modes import E_STOP_STRIDE, STILLING, Cause, Request
from controller.schema.parameters import Settings
from controller.schema.states import LIVE
from controller.system.thread import SupervisedThread
from server.access.permit import Permit, own
from server.http.given import given
from server.operate.job import Acknowledgements, Job
from server.operate.job import Target as Target
from server.operate.stopper import Stopper

REPEAT_S = 0.1
"""Between repetitions of the command."""
_ANSWERS = (KeyRefused, LayoutMismatch, ParameterError, CommandRefused)
"""Refusals by which the rig says that it did not take the record."""

JOBS_MAX = 100
"""Requests that wait for the rig at once; an E-STOP takes the place of all of them."""
END_MAX_S = 5.0
"""Longest wait for the call that is under way at the end."""

Hears = Callable[[Request, Permit | None], None]
"""What is asked for, NONE where the target moves, and by whose leave: none for an E-STOP."""


class Operator:
    """Sends the desired command to the rig and resolves each asker's future with the rig's reply.

    `send` is the blocking call to the rig, `boot` the boot of the rig that is connected (None: not connected), `newest`
    its newest telemetry row: numbers go on from what the rig echoes, so no restart can repeat a request.
    """

    def __init__(
        self,
        send: Callable[[Command], CommandReply],
        boot: Callable[[], int | None],
        newest: Callable[[], Rows | None],
        settings: Settings,
        stopper: Stopper,
    ) -> None:
        self._send, self._connected, self._newest, self.stopper = send, boot, newest, stopper
        self._command = Command(settings=settings)
        self._boot: int | None = None
        self._unsure = False
        """A record that may move the rig was not answered."""
        self._stops = 0
        self._jobs: deque[Job] = deque()
        self._hears: list[Hears] = []
        self._wake = threading.Condition()
        self._present, self._signed = 0, own()
        self._mover: Permit | None = None
        """Whose permit began the motion that the rig accepted last."""
        self._leaving = self._closed = False
        self.acknowledgements = Acknowledgements(boot, newest)
        self.worker = SupervisedThread("operator", self._run)
        self.worker.start()

    @property
    def settings(self) -> Settings:
        """The settings that the rig has accepted."""
        return self._command.settings

    def listen(self, hears: Hears) -> None:
        """Tell `hears` of whatever moves or stops the rig, before it is sent; from any thread."""
        self._hears.append(hears)

    def move(self, target: Target, permit: Permit) -> "Future[CommandReply]":
        """Move the live target; while a call is under way only the newest one is kept, and answers for all."""
        return self.request(Request.NONE, permit, target)

    def change(self, settings: Settings, permit: Permit) -> "Future[CommandReply]":
        """Put other settings in force; they are kept only when the rig accepts them."""
        return self.request(Request.NONE, permit, settings=settings)

    def hold_left(self) -> None:
        """HOLD what began by who no longer operates; what began by who operates now, or waits to, goes on."""
        permit = Permit(None, lambda request: self._moves_for_holder(), STILLING)
        with self._wake:
            self._jobs.append(self._dated(Job(permit, Request.HOLD)))
            self._wake.notify()

    def _moves_for_holder(self) -> str:
        return "the operator of now began this motion" if self._mover is not None and self._mover.stands() else ""

    def stop(self, who: str = "") -> "Future[CommandReply]":
        """E-STOP, for anyone, who is then named: it passes everything that is under way, and ends what waits."""
        with self._wake:
            self._stops += 1
        answer = self.stopper.stop(who)
        for hears in self._hears:
            hears(Request.E_STOP, None)
        with self._wake:
            self._drop(CommandRefused("overtaken by an E-STOP"))
        return answer

    def present(self, permit: Permit) -> None:
        """The page of the permit's holder gave a fresh sign: the next command says so, if the holder still operates.

        Only for signs that come from the page itself at this moment; nothing that the server does is one.
        """
        if permit.signed or permit.sign():
            with self._wake:
                self._present += 1
                self._signed = permit

    def leave(self) -> None:
        """Take nothing more but REST and E_STOP: this server is about to end."""
        self._leaving = True

    def close(self) -> None:
        """Stop sending; the rig then holds, and later rests, by itself."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        self.worker.stop(END_MAX_S)
        self.stopper.close()

    def request(
        self, request: Request, permit: Permit, target: Target | None = None, settings: Settings | None = None
    ) -> "Future[CommandReply]":
        """Ask for another mode, or for what may change without; NotAllowed if `permit` does not cover that at the
        moment at which it is about to be sent.
        """
        asker: Future[CommandReply] = Future()
        asker.set_running_or_notify_cancel()
        job = Job(permit, request, target, settings, askers=[asker])
        if settings is None:
            for hears in self._hears:
                hears(request, permit)
        with self._wake:
            if permit.signed:
                self._present += 1
                self._signed = permit
            if request != Request.NONE:
                self._dated(job)
            if self._closed:
                job.fail(RigUnreachable("the server is shutting down"))
            elif self._leaving and job.request != Request.REST:
                job.fail(CommandRefused("refused: the server is shutting down, and the rig comes to rest"))
            elif len(self._jobs) >= JOBS_MAX and job.request not in STILLING:
                job.fail(CommandRefused(f"{len(self._jobs)} requests wait for the rig already: ask again"))
            elif self._jobs and job.moves_only and self._jobs[-1].moves_only:
                self._jobs[-1].target, self._jobs[-1].permit = job.target, job.permit
                self._jobs[-1].askers += job.askers
            else:
                if job.request in STILLING:
                    self._drop(CommandRefused(f"overtaken by {job.request.name}"), lambda waiting: waiting.moves)
                self._jobs.append(job)
            self._wake.notify()
        return asker

    def _drop(self, error: TendrilError, which: Callable[[Job], bool] = lambda job: True) -> None:
        jobs = list(self._jobs)
        self._jobs = deque(job for job in jobs if not which(job))
        for job in jobs:
            if which(job):
                job.fail(error)

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            self.worker.turn()
            self.acknowledgements.look()
            with self._wake:
                if not (self._jobs or self._closed):
                    self._wake.wait(max(0.0, due - time.monotonic()))
                if self._closed:
                    self.acknowledgements.look(all_of_them=True)
                    return self._drop(RigUnreachable("the server is shutting down"))
                if not self._jobs and time.monotonic() < due:
                    continue
                job = self._jobs.popleft() if self._jobs else Job()
            due = time.monotonic() + REPEAT_S
            try:
                self._serve(job)
            except BaseException:  # this thread ends, and begins again: no asker may wait for what it was about to say
                job.fail(RigUnreachable("the server's thread to the rig ended"))
                raise

    def _serve(self, job: Job) -> None:
        try:
            if self._unsure:
                self._settle(job)
            reply = self._call(job)
        except TendrilError as error:
            return job.fail(error)
        except Exception as error:  # the heartbeat must outlive any failure of one call
            return job.fail(RigUnreachable(f"the command could not be sent: {error}"))
        if reply.accepted and job.request != Request.NONE:
            self.acknowledgements.add(job, reply, self._boot, self._command.request_n)
        else:
            job.answer(reply)

    def _settle(self, job: Job) -> None:
        """After a record that may have moved the rig and was not answered: HOLD first, and a drag must begin again."""
        newest = self._newest()
        if newest is None or newest[0]["mode"] not in LIVE or job.request in STILLING:
            return
        self._call(self._dated(Job(own(), Request.HOLD)))
        if job.moves_only:
            raise CommandRefused("the last target was not answered, so the rig was told to hold: begin again")

    def _call(self, job: Job) -> CommandReply:
        boot, newest = self._connected(), self._newest()
        if boot is None or newest is None:
            raise RigUnreachable("the rig does not answer")
        if boot != self._boot:
            self._command = _resume(newest[0], boot, self._command.settings)
            self._boot, self._unsure = boot, False
        if job.request != Request.NONE:
            self._require_current(job, boot, self._used(newest[0], boot))
        if job.permit is not None:
            job.permit.require(job.request)
        before, command = self._command, self._next(job, newest[0])
        # Until the rig has taken it, the next record must not carry the settings; its numbers are used up all the same,
        # and its target is the newest that the rig may have: no older one may follow.
        used = {"n": command.n, "request_n": command.request_n, "presence": command.presence, "target": command.target}
        self._command = before.model_copy(update=used)
        try:
            reply = self._send(command)
        except RigHeld:
            self._boot = None  # what the other server does to target and numbers is read before we command again
            raise
        except _ANSWERS:
            self._command = self._command.model_copy(update={"target": before.target})
            raise
        except Exception:
            self._unsure |= job.moves
            raise
        self._unsure = job.moves and reply.cause == Cause.LOOP_STALLED and not reply.accepted
        if reply.accepted:
            self._command = command.model_copy(update={"request": Request.NONE})
            if job.request in (Request.FOLLOW, Request.TRACK):
                self._mover = job.permit
        return reply

    def _next(self, job: Job, newest: Any) -> Command:
        last, presence = self._command, self._command.presence
        with self._wake:
            signs, self._present, signed = self._present, 0, self._signed
        if signs and (signed is job.permit or signed.stands()):
            # The rig takes only a number above all that it has seen, of any server.
            presence = max(presence, int(newest["presence"])) + signs
        commissioning = int(job.permit is not None and job.permit.commissioning)
        changes: dict[str, Any] = {"n": last.n + 1, "presence": presence, "commissioning": commissioning}
        if job.request != Request.NONE:
            used = max(last.request_n, self._used(newest, last.boot))
            changes |= {"request": job.request, "request_n": used + 1}
        if job.target is not None:
            changes["target"] = job.target
        if job.settings is not None:
            changes["settings"] = job.settings
        return last.model_copy(update=changes)

    def _used(self, newest: Any, boot: int) -> int:
        """The highest request number that the rig is known to have used, of any server."""
        return max(int(newest["request_n"]), self.stopper.passed(boot))

    def _dated(self, job: Job) -> Job:
        """With what is known of the rig as it is asked for."""
        boot, newest = self._connected(), self._newest()
        job.boot, job.stops = boot, self._stops
        job.used = 0 if boot is None or newest is None else self._used(newest[0], boot)
        return job

    def _require_current(self, job: Job, boot: int, used: int) -> None:
        """Raise unless the request was meant for this boot of the rig, and no E-STOP came after it, at any server."""
        if job.boot is None and job.request not in STILLING:  # those are good in any boot
            raise RigUnreachable("the rig was silent when this was asked for: ask again")
        if job.boot not in (None, boot):
            raise CommandRefused("the rig restarted since this was asked for")
        if self.stopper.waits:
            raise CommandRefused("an E-STOP waits for the rig's answer")
        if job.stops != self._stops or (job.boot == boot and used >= job.used + E_STOP_STRIDE):
            raise CommandRefused("overtaken by an E-STOP")


def _resume(row: Any, boot: int, settings: Settings) -> Command:
    """The command that changes nothing in a new boot of the rig but the settings, numbered on from what it echoes."""
    return Command(
        n=int(row["command_n"]),
        request_n=int(row["request_n"]),
        presence=int(row["presence"]),
        boot=boot,
        target=(float(row["target"][0]), float(row["target"][1])),
        settings=settings,
    )


GivenOperator = Annotated[Operator, given(Operator)]
