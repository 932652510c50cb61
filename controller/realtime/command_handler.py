"""The rig process answers the link here: commands go into the loop's mailbox, and its rows say what became of them."""

import threading
import time
from collections.abc import Callable

import numpy as np

from controller.arrays import Words
from controller.drivers.driver import Driver
from controller.drivers.twin import inject
from controller.errors import CommandRefused
from controller.kernels.memory import Control
from controller.kernels.plant.hardware import Hardware
from controller.link import PlannedRows
from controller.realtime.followable import mistuned, put_planned, require_followable, require_sound
from controller.realtime.latch import Latch
from controller.realtime.mailbox import post, words
from controller.realtime.pause import Pause
from controller.realtime.ring import Ring
from controller.schema.hardware import Drivers
from controller.schema.layout import to_record
from controller.schema.messages import Command, CommandReply, RigInfo, TwinFaults, TwinTime
from controller.schema.modes import E_STOP_STRIDE, STILLING, Cause, Law, Mode, Request, RowKind, refused_text
from controller.schema.states import LIVE
from controller.schema.titles import CHAMBERS

ECHO_MIN_S, ECHO_MAX_S = 0.05, 0.4
"""Wait for a tick that saw a command: as long as the rig's limits let the loop pause, between these two."""
LEAP = E_STOP_STRIDE
"""By how much a command's n, request_n and presence may be above the rig's own at most: those that come later must
still be able to number on from there."""
DISK_S = 0.25
"""Wait for the disk that keeps what is latched, before an answer says that it is not there yet."""
STOPS_MAX = 256
"""E-STOPs whose repetitions are known."""
START_NEAR_M = 3e-3
"""A planned reference begins this near to where the rig's own reference stands, unless it declares steps."""
STANDING = (Mode.HOLD, Mode.FOLLOW)
GOES_ON = STILLING | {Request.E_STOP}
"""What ends a pause of the twin, so that it is obeyed at once."""
UNCOMMISSIONED = (
    "refused: drivers, chambers, frame and signs of this rig are not all accepted; until they are it is armed for the "
    "steps of its commissioning only"
)
LOOK_S = 1e-4
"""Between two looks at the ring: a tenth of a tick."""

Stopper = tuple[int, int]
"""Which E-STOP of which server: a session, and a number that this server gives to one press."""


class CommandHandler:
    """Serves the link (RigService) with the loop's mailbox and ring."""

    def __init__(
        self, info: RigInfo, ring: Ring, commands: Words, control: Control, driver: Driver, latch: Latch
    ) -> None:
        """`driver` of the plant: what it says of its devices, and the faults of a twin."""
        self._info, self._latch = info, latch
        self._ring = ring
        self._commands = commands
        self._control = control
        self._driver, self._injected = driver, TwinFaults()
        self.pause = Pause(ring)
        self._last = Command()
        """The record in the mailbox, without its request."""
        self._used = self._stop_n = 0
        """The highest number of a request that was posted; that of the newest E-STOP."""
        self._stops: dict[Stopper, int] = {}
        self._one_at_a_time, self._posting = threading.Lock(), threading.Lock()
        """The first is held until a command is answered, the second only while the mailbox is written."""
        self._begin: np.ndarray | None = None

    def info(self) -> RigInfo:
        """Who the rig is."""
        return self._info.model_copy(update={"latched": self._latch.kept})

    def replay(self, first: int, count: int) -> np.ndarray:
        """Rows of ticks [first, first + count) still in the ring; tick k is row k of the ring."""
        start, rows = self._ring.read(first, count)
        return rows[: max(0, first + count - start)]

    def submit(self, command: Command) -> CommandReply:
        """Put the command into the mailbox, wait for the tick that looked at it, and say what that made of it.

        A command for another boot of the rig is refused whole, its settings and target too, and so is a request whose
        number was used: by this server, by another one, or passed over by an E-STOP.
        """
        if command.boot != self._info.boot:
            text = refused_text(command.request, self._mode(), Cause.WRONG_BOOT)
            return _reply(command, self._mode(), Cause.WRONG_BOOT, text)
        self.pause.hear()
        with self._one_at_a_time:
            if refused := self._refused(command):
                return _reply(command, self._mode(), Cause.NONE, refused)
            return self._put(command)

    def stop(self, who: Stopper, boot: int | None = None, by: str = "") -> CommandReply:
        """E-STOP, from any server and past every command that is being answered; the reply's n is the request's number.
        It is kept with the name `by` before it is answered.

        Nothing else changes: settings, target and presence stay as they are. Asked once more with the same `who`, it is
        answered and not acted on again. Its number is E_STOP_STRIDE above all that was used: requests number on
        from what the rig echoes, so none that was asked before this E-STOP was seen can be above it, wherever it was
        delayed.
        One meant for another `boot`, on its way since, is refused: this one began vented.
        """
        if boot not in (None, self._info.boot):
            text = refused_text(Request.E_STOP, self._mode(), Cause.WRONG_BOOT)
            return CommandReply(n=0, accepted=False, mode=self._mode(), cause=Cause.WRONG_BOOT, detail=text)
        with self._posting:
            self.pause.end()
            number = self._stops.get(who)
            if number is None:
                number = max(self._used, self._echoed()) + E_STOP_STRIDE
                self._post(self._last, number)
                self._used = self._stop_n = self._stops[who] = number
                while len(self._stops) > STOPS_MAX:
                    del self._stops[next(iter(self._stops))]
        return self._answered_stop(number, by)

    def _put(self, command: Command) -> CommandReply:
        before = self._last
        with self._posting:
            if command.request and command.request_n <= (used := max(self._used, self._echoed())):
                return _older(command, self._mode(), used)
            since, posted_ns = self._ring.head, time.monotonic_ns()
            self._post(command)
            self._used = max(self._used, command.request_n if command.request else 0)
            self._last = _plain(command)
        row = self._row_of(command, since, posted_ns)
        if row is None and command.request:
            row = self._withdrawn(command, before, since)
        if row is not None:
            return self._answered(command, row)
        return _reply(command, self._mode(), Cause.LOOP_STALLED, "refused: the control loop does not answer")

    def _answered(self, command: Command, row: np.void) -> CommandReply:
        reply = answer(command, row)
        if command.request == Request.CLEAR and reply.accepted:
            self._latch.clear(row)
            if why := self._latch.on_disk(DISK_S):
                detail = f"{reply.detail}; it would be latched again after a restart: {why}"
                return reply.model_copy(update={"detail": detail})
        return reply

    def _post(self, command: Command, stop_n: int = 0) -> None:
        """Into the mailbox, with `_posting` held; an E-STOP that no tick has shown yet, or `stop_n`, goes along."""
        stop_n = max(stop_n, self._stop_n)
        if stop_n > self._echoed():
            command = command.model_copy(update={"request": Request.E_STOP, "request_n": stop_n})
        post(self._commands, words(to_record(command)))

    def _withdrawn(self, command: Command, before: Command, since: int) -> np.void | None:
        """Take back a request at which no tick looked in time: what was answered as refused must not act later.

        The row of it, if a tick had taken it just before.
        """
        with self._posting:
            if self._last == _plain(command):
                self._last = before.model_copy(update={"n": command.n})
                self._post(self._last)
        return self._first_row(command.request_n, since)

    def _answered_stop(self, number: int, by: str) -> CommandReply:
        row = self._wait(lambda row: row["request_n"] >= number)
        self._latch.look(row, by)
        taken, mode = row is not None, self._mode()
        text = mode.name if taken else "the control loop does not answer; the E-STOP waits there"
        if taken and (why := self._latch.on_disk(DISK_S)):
            text += f"; it would not outlive the rig's process: {why}"
        cause = Cause.NONE if taken else Cause.LOOP_STALLED
        return CommandReply(n=number, accepted=taken, mode=mode, cause=cause, detail=text)

    def _echoed(self) -> int:
        """The last request at which a tick has looked."""
        newest = self._ring.newest()
        return 0 if newest is None else int(newest["request_n"])

    def _mode(self) -> Mode:
        newest = self._ring.newest()
        return Mode.VENTED if newest is None else Mode(newest["mode"])

    def plan(self, rows: PlannedRows) -> int:
        """Take `rows` as the reference of the next TRACK run; refused while one is under way, and beyond the bounds."""
        require_sound(rows, len(self._control.reference))
        newest = self._ring.newest()
        guide = np.full(rows.points.shape, np.nan) if rows.torques is None else rows.torques
        stand = np.zeros(2) if newest is None else newest["u_ff"].copy()
        require_followable(rows, stand, self._control, self._info.parameters.controller)
        with self._one_at_a_time:
            row = self._ring.newest()
            if row is not None and row["mode"] == Mode.TRACK:
                raise CommandRefused("refused: the reference cannot change while it is tracked; hold first")
            count = len(rows.points)
            self._control.reference[:count], self._control.guide[:count] = rows.points, guide
            put_planned(rows, self._control)
            self._control.kinds[:count] = RowKind.DRAWN if rows.kinds is None else rows.kinds
            self._control.plan[0] = count, rows.again, rows.ticks
            self._begin = None if rows.steps else rows.points[0].copy()
        return count

    def _refused(self, command: Command) -> str:
        """Why the loop is not asked, "" where it is. What stills the rig ends a pause of its twin."""
        if why := self._leaps(command):
            return why
        if command.settings != self._last.settings and (why := mistuned(command.settings, self._info.controllers)):
            return why
        if self.pause.on and command.request in GOES_ON:
            self.pause.end()
        if self.pause.on and command.request:
            return f"refused: {command.request.name} is not possible while the twin is paused; continue it first"
        if command.request == Request.ARM and (why := self._driver.unready() or self._full()):
            return f"refused: {why}"
        hardware = self._info.parameters.hardware
        missing = hardware is not None and hardware.commissioned == "missing"
        return (self._uncommissioned(command) if missing else "") or self._too_far(command)

    def _uncommissioned(self, command: Command) -> str:
        """Why devices that are not commissioned do not do it, "" where they do.

        Frame, signs and chambers may be wrong: the steps that find them arm in open loop, and nothing closes it.
        """
        closes = command.settings.law != Law.OPEN_LOOP
        if command.request == Request.ARM and (closes or not command.commissioning):
            return UNCOMMISSIONED
        ends = command.request in (Request.REST, Request.E_STOP)
        return UNCOMMISSIONED if closes and self._mode() in LIVE and not ends else ""

    def _full(self) -> str:
        """Which chamber of devices holds pressure though it is vented, "" for none: what is shown as vented is not."""
        row, parameters = self._ring.newest(), self._info.parameters
        if parameters.hardware is None or row is None or row["mode"] != Mode.VENTED:
            return ""
        chamber = int(np.argmax(row["pressure_meas"]))
        held = float(row["pressure_meas"][chamber])
        if held <= parameters.limits.pressure_off_max:
            return ""
        return (
            f"{CHAMBERS[chamber]} holds {1e-3 * held:.0f} kPa though it is vented: wait until it is empty, or see to "
            "its valve and its supply"
        )

    def _leaps(self, command: Command) -> str:
        """Why the numbers of `command` would leave none for later ones, "" where they number on from the rig's own."""
        row = self._ring.newest()
        known = {"n": "command_n", "request_n": "request_n", "presence": "presence"}
        for field, column in known.items():
            number = getattr(command, field)
            used = max(getattr(self._last, field), 0 if row is None else int(row[column]))
            used = max(used, self._used) if field == "request_n" else used
            if number > used + LEAP:
                return f"refused: {field} = {number} is more than {LEAP} above {used}, the rig's own; number on from it"
        return ""

    def _too_far(self, command: Command) -> str:
        """Why a TRACK cannot begin from where the reference stands now, "" if it can."""
        row = self._ring.newest()
        if command.request != Request.TRACK or row is None or row["mode"] not in STANDING or self._begin is None:
            return ""
        apart = float(np.hypot(*(row["p_ref"] - self._begin)))
        if apart <= START_NEAR_M:
            return ""
        return (
            f"refused: the planned reference begins {1e3 * apart:.1f} mm from where the rig's own is, more than "
            f"{1e3 * START_NEAR_M:g} mm; plan it from there"
        )

    def faults(self, wanted: TwinFaults | None) -> TwinFaults:
        """Inject faults into the twin, None changes nothing; those in force. Refused on hardware."""
        plant = self._driver.plant
        if isinstance(plant, Hardware):
            raise CommandRefused("refused: faults can be injected into the twin only, and this rig is hardware")
        with self._one_at_a_time:
            if wanted is not None:
                inject(wanted, plant.faults)
                self._injected = wanted
            return self._injected

    def time(self, wanted: TwinTime | None) -> TwinTime:
        """Let the twin's time stand still, go on, or go on by steps; None changes nothing. Refused on hardware."""
        if not self._driver.simulated:
            raise CommandRefused("refused: only the twin can be paused, and this rig is hardware")
        with self._one_at_a_time, self._posting:
            if wanted is not None:
                self._set_time(wanted)
            return self.pause.state()

    def drivers(self) -> Drivers:
        """How the rig's devices fare; none of a twin."""
        return Drivers(drivers=self._driver.status())

    def _set_time(self, wanted: TwinTime) -> None:
        if wanted.steps and not wanted.paused:
            raise CommandRefused(f"refused: steps = {wanted.steps} are taken only while the twin is paused")
        if wanted.paused and self._stop_n > self._echoed():
            raise CommandRefused("refused: an E-STOP is under way")
        self.pause.hear()
        self.pause.put(wanted)

    def _row_of(self, command: Command, since: int, posted_ns: int) -> np.void | None:
        """The row that says what became of `command`, None in time: for a request the first row that has its number.

        A later one may show what another request, an E-STOP, made of it; `since` is the ring's head before the post.
        While the twin is paused the next tick will look at what asks for nothing: its last row is the answer.
        """
        if not command.request:
            return self._wait(lambda row: row["t_ns"] > posted_ns or self.pause.rests)
        shown = self._wait(lambda row: row["request_n"] >= command.request_n)
        return None if shown is None else self._first_row(command.request_n, since)

    def _wait(self, shows: Callable[[np.void], bool]) -> np.void | None:
        """The acknowledgement: the newest row once it `shows` it, None where the loop does not tick in time."""
        pause = self._info.parameters.limits.loop_gap
        end = time.monotonic_ns() + int(min(max(ECHO_MIN_S, pause), ECHO_MAX_S) * 1e9)
        while True:
            late, row = time.monotonic_ns() >= end, self._ring.newest()
            if row is not None and shows(row):
                return row
            if late:
                return None
            time.sleep(LOOK_S)

    def _first_row(self, request_n: int, since: int) -> np.void | None:
        rows = self._ring.read(since, max(0, self._ring.head - since))[1]
        found = np.flatnonzero(rows["request_n"] >= request_n)
        return rows[found[0]] if len(found) else None


def answer(command: Command, row: np.void) -> CommandReply:
    """What the tick of `row` made of `command`, in one sentence for the operator."""
    mode, cause = Mode(row["mode"]), Cause(row["cause"])
    if command.request and command.request_n < row["request_n"]:
        return _older(command, mode, int(row["request_n"]))
    refusal = Cause(row["request_cause"]) if command.request else Cause.NONE
    if refusal == Cause.NONE:
        return _reply(command, mode, cause, mode.name, accepted=True)
    return _reply(command, mode, refusal, refused_text(command.request, mode, refusal))


def _older(command: Command, mode: Mode, used: int) -> CommandReply:
    text = f"refused: request {command.request_n} is older than request {used} of an E-STOP or another server"
    return _reply(command, mode, Cause.NONE, f"{text}; look at the rig's state and ask again")


def _plain(command: Command) -> Command:
    """The same without its request, as it may be posted again."""
    return command.model_copy(update={"request": Request.NONE})


def _reply(command: Command, mode: Mode, cause: Cause, detail: str, *, accepted: bool = False) -> CommandReply:
    return CommandReply(n=command.n, accepted=accepted, mode=mode, cause=cause, detail=detail)
