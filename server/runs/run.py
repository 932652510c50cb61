"""One run as the rig's rows tell it: approach, laps, pauses, and how it ends. It knows no clock and sends nothing."""

import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from controller.arrays import Array, Rows
from controller.schema.modes import Cause, Mode
from server.log.events import words
from server.runs.lap import Lap, Leg, Order, Place
from server.runs.learning.seen import Repeat, Seen
from server.runs.messages import Learned, RunResult, RunState
from server.runs.phases import Event, Machine, Phase
from server.runs.tally import Tally

READY = (Mode.HOLD, Mode.FOLLOW)
"""A run may begin or go on from these."""


@dataclass(frozen=True)
class About:
    """What is known of a run when it begins."""

    id: int
    order: Order
    time: datetime
    K_FF: tuple[float, float] = (0.0, 0.0)
    """Velocity feedforward that it begins with [s]."""
    controller: str = ""
    """In the slot."""

    @property
    def lap(self) -> Lap:
        """What is followed."""
        return self.order.lap

    @property
    def laps(self) -> int | None:
        """How often; None: until stopped."""
        return self.order.laps

    @property
    def dt(self) -> float:
        """Period of the rows [s]."""
        return self.order.rig.controller.dt


@dataclass(frozen=True)
class Before:
    """The rig's row in HOLD from which a leg is asked for: what comes after it tells of the leg."""

    tick: int = -1
    request_n: int = 0


class Run:
    """Give it every row from the request to track a leg on, in order; between two legs it is paused.

    The rows move `machine`, which others move too.
    """

    def __init__(self, about: About, leg: Leg, machine: Machine, before: Before, recording: str | None = None) -> None:
        self.about, self.machine = about, machine
        self.recording = recording
        self.left = Place(0, about.lap.u[0])
        """How far it is, for the next leg."""
        self._leg, self._before = leg, before
        self._first: int | None = None
        self._moved = 0
        self._error: float | None = None
        self._tally = Tally(about.lap.frequency, about.dt)
        self._noted = 0
        self._notes: list[tuple[int, int]] = []
        self._learned = leg.learned
        self._seen = Seen(leg) if leg.learned is not None and leg.learned.learning else None

    def notes(self) -> list[tuple[int, int]]:
        """First tick and end of each stretch that is not judged and that began since this was asked last."""
        notes, self._notes = self._notes, []
        return notes

    @property
    def tracked(self) -> bool:
        """Whether the rig was seen to track this leg."""
        return self._first is not None

    def begin(self, leg: Leg, before: Before) -> None:
        """The rig is asked to track another leg, after a pause."""
        self._leg, self._before, self._first = leg, before, None
        self._tally.pause()
        if self._learned is not None:  # from a run with a pause nothing is learned
            self._learned, self._seen = self._learned.model_copy(update={"learning": False}), None

    def take(self, rows: Rows) -> None:
        """Telemetry rows (n,), oldest first."""
        if self.machine.moving:
            rows = self._track(rows)
        elsewhere = rows[~np.isin(rows["mode"], READY)]
        if self.machine.phase in (Phase.PAUSED, Phase.RETURNING) and len(elsewhere):
            self._leave(elsewhere[0])

    def state(self) -> RunState:
        """As the page shows it."""
        about, done, lap = self.about, self.left.done, len(self.about.lap.p)
        share = done % lap / lap if about.laps is None else done / about.lap.rows(about.laps)
        return RunState(
            id=about.id,
            name=about.lap.name,
            state=self.machine.shown,
            reason="" if self.machine.moving else self.machine.reason,
            lap=max(done - 1, 0) // lap + 1,
            laps=about.laps,
            elapsed=self._moved * about.dt,
            duration=lap * about.dt,
            progress=share,
            error=self._error if self.machine.moving else None,
            error_rms=self._tally.rmse,
            recording=self.recording,
        )

    def result(self) -> RunResult:
        """What came of it."""
        about, done = self.about, self.left.done
        whole = self.machine.phase == Phase.DONE and about.laps is not None
        return RunResult(
            id=about.id,
            name=about.lap.name,
            time=about.time,
            laps=float(about.laps or 0) if whole else done / len(about.lap.p),
            state=self.machine.shown,
            reason=self.machine.reason,
            duration=self._moved * about.dt,
            recording=self.recording,
            K_FF=about.K_FF,
            controller=about.controller,
            learned=self._learned_by_now(),
            errors=tuple(self._tally.course.parts()),
            **self._tally.figures().model_dump(),
        )

    def repeat(self) -> Repeat | None:
        """What its path is to be learned from, once it has ended of itself or by the rig; None where it is not to."""
        if self._seen is None or self._learned is None or self.machine.phase not in (Phase.DONE, Phase.BROKEN):
            return None
        done = self.machine.phase == Phase.DONE
        return Repeat(self._learned, self._seen if done else None, self._tally.rmse if done else None)

    def _learned_by_now(self) -> Learned | None:
        repeat = self.repeat()
        if repeat is None:
            return self._learned
        return repeat.before.model_copy(update={"errors": (*repeat.before.errors, repeat.rmse)})

    def _track(self, rows: Rows) -> Rows:
        """Follow the rows in TRACK; the rows after them."""
        on = rows["mode"] == Mode.TRACK
        if self._first is None:
            rows, on = self._answered(rows)
            if not len(rows) or not on[0]:
                return self._leave(rows[0], rows[1:]) if len(rows) else rows
            self._first = self._noted = int(rows["tick"][0])
        count = len(rows) if on.all() else int(np.argmin(on))
        if count:
            self._follow(rows[:count], self._first)
        return self._leave(rows[count], rows[count:]) if count < len(rows) else rows[count:]

    def _answered(self, rows: Rows) -> tuple[Rows, np.ndarray]:
        """The rows from the first on that tells what became of the request to track, and which are in TRACK.

        A rig that took it may have left TRACK in the same tick: no row shows it, but the number of the request rises.
        """
        on = rows["mode"] == Mode.TRACK
        asked = (rows["request_n"] > self._before.request_n) & (rows["request_cause"] == Cause.NONE)
        tells = (rows["tick"] > self._before.tick) & (on | asked | ~np.isin(rows["mode"], READY))
        first = int(np.argmax(tells)) if tells.any() else len(rows)
        return rows[first:], on[first:]

    def _follow(self, rows: Rows, first: int) -> None:
        leg, index = self._leg, rows["tick"] - first
        judged = ~leg.travel[leg.row(index)]
        self._note(rows["tick"][~judged], first)
        self._tally.add(rows[judged])
        if self._seen is not None:
            self._seen.add(index, rows)
        self._moved += len(rows)
        self.left = Place(leg.done + max(0, int(index[-1]) + 1 - leg.again), rows["u_ff"][-1].copy())
        error = float(np.linalg.norm(rows["p_ref"][-1] - rows["p_meas"][-1]))
        self._error = error if math.isfinite(error) else None
        self.machine.meet(Event.SHAPE if index[-1] >= leg.again else Event.LEAD)

    def _note(self, ticks: Array, first: int) -> None:
        """Note the stretches of travel that the ticks (k,) are in, to their ends."""
        while len(ticks := ticks[ticks >= self._noted]):
            tick = int(ticks[0])
            row = int(self._leg.row(np.array([tick - first]))[0])
            judged = np.flatnonzero(~self._leg.travel[row:])
            self._noted = tick + (int(judged[0]) if judged.size else len(self._leg.travel) - row)
            self._notes.append((tick, self._noted))

    def _leave(self, row: np.void, rest: Rows | None = None) -> Rows:
        """The rig no longer tracks: because it is done, or was asked for something else, or by itself."""
        mode, cause = Mode(int(row["mode"])), Cause(int(row["cause"]))
        if cause == Cause.REFERENCE_DONE:
            self.machine.meet(Event.FINISHED)
        elif cause == Cause.OPERATOR and mode != Mode.E_STOP:
            event = Event.HELD if mode == Mode.HOLD else Event.REDIRECTED
            self.machine.meet(event, f"the operator asked for {words(mode)}")
        else:
            self.machine.meet(Event.LEFT, f"{words(mode)} ({words(cause)})")
        return np.empty(0, row.dtype) if rest is None else rest
