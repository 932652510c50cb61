"""One run as the rig's rows tell it: approach, laps, pauses, and how it ends. It knows no clock and sends nothing."""

import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from controller.modes import Cause, Mode
from server.channels import Rows
from server.runs.laps import Lap, Leg, Place
from server.runs.messages import Phase, RunResult, RunState
from server.runs.tally import Tally
from server.watch import words

READY = (Mode.HOLD, Mode.FOLLOW)
"""A run may begin or go on from these."""


@dataclass(frozen=True)
class About:
    """What is known of a run when it begins."""

    id: int
    lap: Lap
    laps: int | None
    time: datetime
    dt: float
    """Period of the rows [s]."""


class Run:
    """Give it every row from the request to track a leg on, in order; between two legs it is paused."""

    def __init__(self, about: About, leg: Leg, recording: str | None) -> None:
        self.about = about
        self.recording = recording
        self.phase: Phase = "approach"
        self.reason = ""
        self.left = Place(0, about.lap.u)
        """How far it is, for the next leg."""
        self._leg = leg
        self._first: int | None = None
        self._moved = 0
        self._error: float | None = None
        self._tally = Tally(about.lap.frequency)
        self._asked: tuple[Phase, str] | None = None

    @property
    def moving(self) -> bool:
        """Whether the rig tracks it, or is about to."""
        return self.phase in ("approach", "running")

    @property
    def ended(self) -> bool:
        """Whether nothing more comes of it."""
        return not self.moving and self.phase != "paused"

    @property
    def approach(self) -> tuple[int, int] | None:
        """First tick and end of what led into the shape since the start or the last pause; None before it began."""
        return None if self._first is None else (self._first, self._first + self._leg.again)

    def begin(self, leg: Leg) -> None:
        """The rig tracks another leg, after a pause."""
        self.phase, self.reason = "approach", ""
        self._leg, self._first, self._asked = leg, None, None
        self._tally.pause()

    def ask(self, phase: Phase, reason: str) -> None:
        """The rig is asked to hold: that it then holds is to mean `phase`, because of `reason`."""
        self._asked = phase, reason

    def unask(self) -> None:
        """The rig refused, so a hold means again what the rig says."""
        self._asked = None

    def end(self, phase: Phase, reason: str) -> None:
        """It is over, or paused."""
        self.phase, self.reason, self._error = phase, reason, None

    def take(self, rows: Rows) -> None:
        """Telemetry rows (n,), oldest first."""
        if self.moving:
            rows = self._track(rows)
        elsewhere = rows[~np.isin(rows["mode"], READY)]
        if self.phase == "paused" and len(elsewhere):
            self._end_by(elsewhere[0])

    def state(self) -> RunState:
        """As the page shows it."""
        about, done, lap = self.about, self.left.done, len(self.about.lap.p)
        share = done % lap / lap if about.laps is None else done / about.lap.rows(about.laps)
        return RunState(
            id=about.id,
            name=about.lap.name,
            state=self.phase,
            reason=self.reason,
            lap=max(done - 1, 0) // lap + 1,
            laps=about.laps,
            elapsed=self._moved * about.dt,
            duration=lap * about.dt,
            progress=share,
            error=self._error,
            error_rms=self._tally.rmse,
            recording=self.recording,
        )

    def result(self) -> RunResult:
        """What came of it."""
        about, done = self.about, self.left.done
        whole = self.phase == "done" and about.laps is not None
        return RunResult(
            id=about.id,
            name=about.lap.name,
            time=about.time,
            laps=float(about.laps or 0) if whole else done / len(about.lap.p),
            state=self.phase,
            reason=self.reason,
            duration=self._moved * about.dt,
            recording=self.recording,
            **self._tally.figures().model_dump(),
        )

    def _track(self, rows: Rows) -> Rows:
        """Follow the rows in TRACK; the rows after them."""
        on = rows["mode"] == Mode.TRACK
        if self._first is None:
            if not on.any():
                return rows[:0]
            rows, on = rows[np.argmax(on) :], on[np.argmax(on) :]
            self._first = int(rows["tick"][0])
        count = len(rows) if on.all() else int(np.argmin(on))
        if count:
            self._follow(rows[:count], self._first)
        if count < len(rows):
            self._leave(rows[count])
        return rows[count:]

    def _follow(self, rows: Rows, first: int) -> None:
        leg, index = self._leg, rows["tick"] - first
        p_ref, judged = leg.at(index), index >= leg.again
        self._tally.add(p_ref[judged], rows[judged])
        self._moved += len(rows)
        self.phase = "running" if judged[-1] else "approach"
        self.left = Place(leg.done + max(0, int(index[-1]) + 1 - leg.again), rows["u_ff"][-1].copy())
        error = float(np.linalg.norm(p_ref[-1] - rows["p_meas"][-1]))
        self._error = error if math.isfinite(error) else None

    def _leave(self, row: np.void) -> None:
        """The rig no longer tracks: because it is done, or was asked to hold, or by itself."""
        if row["cause"] == Cause.REFERENCE_DONE:
            self.end("done", "")
        elif self._asked and (row["mode"], row["cause"]) == (Mode.HOLD, Cause.OPERATOR):
            self.end(*self._asked)
        else:
            self._end_by(row)

    def _end_by(self, row: np.void) -> None:
        mode, cause = Mode(int(row["mode"])), Cause(int(row["cause"]))
        if cause == Cause.OPERATOR and mode != Mode.E_STOP:
            self.end("stopped", f"the operator asked for {words(mode)}")
        else:
            self.end("broken off", f"{words(mode)} ({words(cause)})")
