"""The rig process answers the link here: commands go into the loop's mailbox, and its rows say what became of them."""

import threading
import time

import numpy as np

from controller.errors import CommandRefused, ParameterError
from controller.kernels.faults import Faults
from controller.kernels.memory import Control
from controller.layout import to_record
from controller.messages import Command, CommandReply, RigInfo, TwinFaults
from controller.modes import Cause, Mode, Request
from controller.realtime.compiled import Words
from controller.realtime.mailbox import post, words
from controller.realtime.ring import Ring

ECHO_MIN, ECHO_MAX = 0.05, 0.4
"""Wait for a tick that saw a command [s]: as long as the rig's limits let the loop pause, between these two."""
COORDINATE_MAX = 2.0
POLL = 1e-4
"""Pause between two looks at the ring [s]."""

REASONS = {
    Cause.WRONG_BOOT: "the rig has restarted since; read its state and arm again",
    Cause.NO_REFERENCE: "no reference is planned",
    Cause.NO_OPERATOR: "no operator is present",
}
NEXT_STEPS = {
    Mode.VENTED: "arm first",
    Mode.REST: "wait until the rig is vented",
    Mode.FAULT: "clear the fault first",
    Mode.E_STOP: "clear the E-STOP first",
}


class Desk:
    """Serves the link (RigService) with the loop's mailbox and ring."""

    def __init__(self, info: RigInfo, ring: Ring, commands: Words, control: Control, faults: Faults | None) -> None:
        """`faults` of the twin in the loop's memory; None on hardware."""
        self._info = info
        self._ring = ring
        self._commands = commands
        self._control = control
        self._faults, self._injected = faults, TwinFaults()
        self._last = self._asked = Command()
        self._one_at_a_time = threading.Lock()

    def info(self) -> RigInfo:
        """Who the rig is."""
        return self._info

    def replay(self, first: int, count: int) -> np.ndarray:
        """Rows of ticks [first, first + count) still in the ring; tick k is row k of the ring."""
        start, rows = self._ring.read(first, count)
        return rows[: max(0, first + count - start)]

    def submit(self, command: Command) -> CommandReply:
        """Put the command into the mailbox, wait for a tick that began after that, and say what it made of it.

        A command for another life of the rig is refused whole, its settings and target too; but an E-STOP never is.
        """
        if command.boot != self._info.boot and command.request != Request.E_STOP:
            text = refused_text(command.request, self._mode(), Cause.WRONG_BOOT)
            return _reply(command, self._mode(), Cause.WRONG_BOOT, text)
        with self._one_at_a_time:
            return self._put(command)

    def stop(self, command: Command) -> CommandReply:
        """An E-STOP of a server that does not command this rig: settings, target and presence stay as they are.

        The loop acts on risen numbers only and that server may know an old one, so the number is given here.
        """
        with self._one_at_a_time:
            number = max(command.request_n, self._asked.request_n + 1)
            request = {"n": command.n, "request": command.request, "request_n": number}
            return self._put(self._last.model_copy(update=request))

    def _put(self, command: Command) -> CommandReply:
        asked = self._asked
        if command.request and command.request_n == asked.request_n and command.request != asked.request:
            text = f"refused: request {command.request_n} was {asked.request.name} of another server; ask again"
            return _reply(command, self._mode(), Cause.NONE, text)
        if command.request and command.request_n > asked.request_n:
            self._asked = command
        self._last = command
        post(self._commands, words(to_record(command)))
        row = self._row_after(time.monotonic_ns())
        if row is not None:
            return answer(command, row)
        return _reply(command, self._mode(), Cause.LOOP_STALLED, "refused: the control loop does not answer")

    def _mode(self) -> Mode:
        newest = self._ring.newest()
        return Mode.VENTED if newest is None else Mode(newest["mode"])

    def plan(self, points: np.ndarray, again: int, ticks: int) -> int:
        """Take (n, 2) points [m] as the reference of the next TRACK run; refused while one is under way.

        Point `again` comes after the last one, and `ticks` points are followed in all.
        """
        room = len(self._control.reference)
        if not 0 < len(points) <= room:
            raise ParameterError(f"reference of {len(points)} points is outside [1, {room}]")
        if not np.all(np.abs(points) <= COORDINATE_MAX):
            raise ParameterError(f"reference holds a coordinate outside [-{COORDINATE_MAX}, {COORDINATE_MAX}] m")
        if not 0 <= again < len(points) or ticks < 1:
            raise ParameterError(f"reference of {len(points)} points cannot go on at {again} for {ticks} ticks")
        with self._one_at_a_time:
            row = self._ring.newest()
            if row is not None and row["mode"] == Mode.TRACK:
                raise CommandRefused("refused: the reference cannot change while it is tracked; hold first")
            self._control.reference[: len(points)] = points
            self._control.plan[0] = len(points), again, ticks
        return len(points)

    def faults(self, wanted: TwinFaults | None) -> TwinFaults:
        """Inject faults into the twin, None changes nothing; those in force. Refused on hardware."""
        if self._faults is None:
            raise CommandRefused("refused: faults can be injected into the twin only, and this rig is hardware")
        with self._one_at_a_time:
            if wanted is not None:
                inject(wanted, self._faults)
                self._injected = wanted
            return self._injected

    def _row_after(self, t_ns: int) -> np.void | None:
        """The newest row of a tick that began after t_ns, or None in time."""
        pause = self._info.parameters.limits.loop_gap
        end = t_ns + int(min(max(ECHO_MIN, pause), ECHO_MAX) * 1e9)
        while time.monotonic_ns() < end:
            row = self._ring.newest()
            if row is not None and row["t_ns"] > t_ns:
                return row
            time.sleep(POLL)
        return None


def inject(wanted: TwinFaults, faults: Faults) -> None:
    """Put `wanted` in force, one number after the other."""
    faults.values[:] = wanted.noise, wanted.sample_loss, wanted.marker_loss, *wanted.jump
    faults.rods[0], faults.freeze[0] = wanted.rods, wanted.freeze
    faults.pneumatics[:] = wanted.sensors_stuck, wanted.valves_stuck, wanted.supply_lost


def answer(command: Command, row: np.void) -> CommandReply:
    """What the tick of `row` made of `command`, in one sentence for the operator."""
    mode, cause = Mode(row["mode"]), Cause(row["cause"])
    if command.request and command.request_n < row["request_n"]:
        text = f"refused: request {command.request_n} is older than request {row['request_n']}"
        return _reply(command, mode, Cause.NONE, text)
    refusal = Cause(row["request_cause"]) if command.request else Cause.NONE
    if refusal == Cause.NONE:
        return _reply(command, mode, cause, mode.name, accepted=True)
    return _reply(command, mode, refusal, refused_text(command.request, mode, refusal))


def refused_text(request: Request, mode: Mode, cause: Cause) -> str:
    """Why `request` was refused in `mode`, as "refused: FOLLOW is not possible in VENTED; arm first"."""
    if cause in REASONS:
        return f"refused: {REASONS[cause]}"
    hint = NEXT_STEPS.get(mode)
    return f"refused: {request.name} is not possible in {mode.name}" + (f"; {hint}" if hint else "")


def _reply(command: Command, mode: Mode, cause: Cause, detail: str, *, accepted: bool = False) -> CommandReply:
    return CommandReply(n=command.n, accepted=accepted, mode=mode, cause=cause, detail=detail)
