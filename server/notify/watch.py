"""Sees at every beat whether there is anything to tell those who do not look at the page."""

import queue
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Literal

import numpy as np

from controller.arrays import Rows
from controller.schema.modes import Cause, Mode
from server.log.events import EventLog, words
from server.notify.messages import Notice
from server.notify.webhook import Webhook
from server.runs.messages import RunResult

TOLD: dict[Mode, Literal["fault", "e_stop"]] = {Mode.FAULT: "fault", Mode.E_STOP: "e_stop"}


class NotifyWatch:
    """Tells of every change to FAULT and E-STOP in the rows, however short, and of what came of a run.

    `last` gives what came of the last run; without a webhook it does nothing.
    """

    watched = "the notices"

    def __init__(
        self, rig: str, last: Callable[[], RunResult | None], webhook: Webhook | None, events: EventLog
    ) -> None:
        self._rig, self._last, self._webhook, self._events = rig, last, webhook, events
        self._mode: int | None = None
        self._changes: queue.SimpleQueue[tuple[Mode, Cause]] = queue.SimpleQueue()
        self._run = self._number()

    def rows(self, rows: Rows) -> None:
        """Take telemetry rows, oldest first, in the link's thread. The mode of the first of all is no news."""
        modes = rows["mode"]
        before = np.concatenate(([modes[0] if self._mode is None else self._mode], modes[:-1]))
        self._mode = int(modes[-1])
        for row in rows[modes != before]:
            if row["mode"] in TOLD:
                self._changes.put((Mode(int(row["mode"])), Cause(int(row["cause"]))))

    def look(self) -> None:
        """Post what there is to tell, in the event loop."""
        if self._webhook is None:
            return
        while not self._changes.empty():
            self._tell_change(self._webhook, *self._changes.get())
        self._look_at_run(self._webhook)
        if news := self._webhook.news():
            self._events.add(news, "warning" if "no notices" in news else "info")

    def _tell_change(self, webhook: Webhook, mode: Mode, why: Cause) -> None:
        cause = words(why)
        text = f"rig {self._rig}: {words(mode)} ({cause})"
        webhook.post(Notice(event=TOLD[mode], rig=self._rig, time=datetime.now(UTC), text=text, cause=cause))

    def _look_at_run(self, webhook: Webhook) -> None:
        before, self._run = self._run, self._number()
        run = self._last()
        if run is None or self._run == before:
            return
        why = f" ({run.reason})" if run.reason else ""
        text = f"rig {self._rig}: run {run.name} {run.state}{why}"
        now = datetime.now(UTC)
        webhook.post(Notice(event="run_end", rig=self._rig, time=now, text=text, cause=run.reason, run=run))

    def _number(self) -> int:
        run = self._last()
        return 0 if run is None else run.id
