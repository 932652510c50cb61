"""What is told to those who do not look at the page: FAULT and E-STOP, however short, and the end of a run."""

from datetime import UTC, datetime
from typing import Literal

from controller.schema.modes import Mode
from controller.system.event_bus import EventBus
from server.health.messages import Notice
from server.health.webhook import Webhook
from server.log.events import EventLog, words
from server.operate.events import ModeChanged
from server.runs.results import RunEnded

TOLD: dict[Mode, Literal["fault", "e_stop"]] = {Mode.FAULT: "fault", Mode.E_STOP: "e_stop"}


class Notices:
    """Posts them. The mode of the first row of all is no news."""

    def __init__(self, rig: str, webhook: Webhook, events: EventLog, bus: EventBus) -> None:
        self._rig, self._webhook, self._events = rig, webhook, events
        self._mode: Mode | None = None
        bus.subscribe(ModeChanged, "the notices of a mode", self._on_mode)
        bus.subscribe(RunEnded, "the notices of a run", self._on_run)

    def look(self) -> None:
        """A job: say what became of them."""
        if news := self._webhook.news():
            self._events.add(news, "warning" if "no notices" in news else "info")

    def _on_mode(self, event: ModeChanged) -> None:
        before, self._mode = self._mode, event.mode
        if event.mode not in TOLD or before in (None, event.mode):
            return
        cause = words(event.cause)
        text = f"rig {self._rig}: {words(event.mode)} ({cause})"
        now = datetime.now(UTC)
        self._webhook.post(Notice(event=TOLD[event.mode], rig=self._rig, time=now, text=text, cause=cause))

    def _on_run(self, event: RunEnded) -> None:
        run = event.result
        why = f" ({run.reason})" if run.reason else ""
        text = f"rig {self._rig}: run {run.name} {run.state}{why}"
        now = datetime.now(UTC)
        self._webhook.post(Notice(event="run_end", rig=self._rig, time=now, text=text, cause=run.reason, run=run))
