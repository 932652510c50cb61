"""Alarm limits per user, in the server's state folder, and the log's line when a figure has passed the operator's."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Annotated, Any

from server.access.user_files import UserFiles
from server.health.messages import AlarmLimits, Limit
from server.health.on_time import OnTime
from server.http.given import given
from server.http.who import Identity
from server.log.events import EventLog

JUDGED_S = 1.0
"""From one judgement to the next."""
SAID_APART_S = 10.0
"""Least time between two lines about the same figure."""
NAMES = {
    "round_trip": "round trip",
    "command_age": "command age",
    "lateness_p99": "lateness p99",
    "lost_ticks": "lost ticks",
    "on_time": "on-time share",
    "residual": "observer residual",
}
UNITS = {"lost_ticks": (1.0, ""), "on_time": (1e2, " %"), "residual": (1e3, " mm")}
MILLISECONDS = (1e3, " ms")


class Alarms:
    """Reads and writes the limits; any thread may."""

    def __init__(self, files: UserFiles) -> None:
        self._files = files
        self._reader = ThreadPoolExecutor(1, "alarm limits")
        self._known: tuple[str, AlarmLimits] = ("", AlarmLimits())
        self._reading: Future[None] | None = None

    def known(self, who: Identity | None) -> AlarmLimits:
        """The user's limits as they were read last, without a wait; they are read again meanwhile. No one has the
        defaults.
        """
        if who is None:
            return AlarmLimits()
        if self._reading is None or self._reading.done():
            self._reading = self._reader.submit(self._learn, who)
        id, limits = self._known
        return limits if id == who.id else AlarmLimits()

    def _learn(self, who: Identity) -> None:
        self._known = who.id, self.read(who)

    def read(self, who: Identity) -> AlarmLimits:
        """The user's limits; the defaults where none are kept, or the file is damaged or of another version."""
        return self._files.read(who, AlarmLimits.model_validate_json) or AlarmLimits()

    def write(self, who: Identity, limits: AlarmLimits) -> None:
        """Keep the user's limits; CommandRefused where the disk does not."""
        self._files.write(who, limits.model_dump_json())

    def forget(self, who: Identity) -> None:
        """Back to the defaults."""
        self._files.forget(who)


GivenAlarms = Annotated[Alarms, given(Alarms)]


class AlarmWatch:
    """Once a second: has a figure passed the operator's red limit? The log says so, in one line that counts crossings.

    `newest` gives the newest row, None while there is no rig; `command_age` the largest since it was last asked [s],
    `lateness` the p99 of the last ticks [s], `limits` those of the operator, `round_trip` that of the operator's page.
    """

    def __init__(
        self,
        newest: Callable[[], Any | None],
        command_age: Callable[[], float],
        lateness: Callable[[], float],
        round_trip: Callable[[], float],
        on_time: OnTime,
        limits: Callable[[], AlarmLimits],
        events: EventLog,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._newest, self._command_age, self._lateness, self._round_trip = newest, command_age, lateness, round_trip
        self._on_time, self._limits, self._events, self._now = on_time, limits, events, now
        self._red: set[str] = set()
        self._said: dict[str, float] = {}

    def judge(self) -> None:
        """Judge the last second."""
        row = self._newest()
        if row is None:
            return
        limits = self._limits()
        for name, value in self._figures(row).items():
            self._judge(name, value, getattr(limits, name))

    def _figures(self, row: Any) -> dict[str, float]:
        """Every figure in SI units, nan where it is not known."""
        return {
            "round_trip": self._round_trip(),
            "command_age": self._command_age(),
            "lateness_p99": self._lateness(),
            "lost_ticks": self._on_time.lost,
            "on_time": self._on_time.share,
            "residual": float(row["residual"]),
        }

    def _judge(self, name: str, value: float, limit: Limit) -> None:
        """A figure that was red is news again only after it has been good, and not before SAID_APART_S."""
        if not limit.passed(value, limit.amber):
            self._red.discard(name)
        fresh = limit.passed(value, limit.red) and name not in self._red
        if fresh and self._now() - self._said.get(name, -math.inf) >= SAID_APART_S:
            self._red.add(name)
            self._said[name] = self._now()
            text = f"{NAMES[name]} {_shown(name, value)} is {limit.side} the limit of {_shown(name, limit.red)}"
            self._events.add(text, "warning", f"alarm {name}")


def _shown(name: str, value: float) -> str:
    scale, unit = UNITS.get(name, MILLISECONDS)
    return f"{value * scale:.4g}{unit}"
