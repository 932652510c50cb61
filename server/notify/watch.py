"""Sees at every beat whether there is anything to tell those who do not look at the page."""

from collections.abc import Callable
from datetime import UTC, datetime

from controller.arrays import Rows
from controller.schema.modes import Cause, Mode
from server.log.events import EventLog, words
from server.notify.messages import Notice
from server.notify.webhook import Webhook
from server.runs.messages import RunResult

TOLD = {Mode.FAULT: "fault", Mode.E_STOP: "e_stop"}


class NotifyWatch:
    """Compares with the beat before. `newest` gives the newest row, `last` what came of the last run; without a
    webhook it does nothing.
    """

    watched = "the notices"

    def __init__(
        self,
        rig: str,
        newest: Callable[[], Rows | None],
        last: Callable[[], RunResult | None],
        webhook: Webhook | None,
        events: EventLog,
    ) -> None:
        self._rig, self._newest, self._last = rig, newest, last
        self._webhook, self._events = webhook, events
        self._mode: Mode | None = None
        self._run = self._number()

    def look(self) -> None:
        """Look once."""
        if self._webhook is None:
            return
        self._look_at_mode(self._webhook)
        self._look_at_run(self._webhook)
        if news := self._webhook.news():
            self._events.add(news, "warning" if "no notices" in news else "info")

    def _look_at_mode(self, webhook: Webhook) -> None:
        newest = self._newest()
        before, self._mode = self._mode, None if newest is None else Mode(int(newest[0]["mode"]))
        if newest is None or before in (None, self._mode) or self._mode not in TOLD:
            return
        cause = words(Cause(int(newest[0]["cause"])))
        text = f"rig {self._rig}: {words(self._mode)} ({cause})"
        webhook.post(Notice(event=TOLD[self._mode], rig=self._rig, time=datetime.now(UTC), text=text, cause=cause))

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
