"""What is told to those who do not look at the page: FAULT and E-STOP, however short, and the end of a run.

Each notice is posted as JSON by a thread of its own: neither event loop nor request waits for it.
"""

import queue
import threading
import time
from datetime import UTC, datetime
from typing import Literal
from urllib.parse import urlsplit

import httpx

from controller.schema.modes import Mode
from controller.system.event_bus import EventBus
from controller.system.thread import SupervisedThread
from server.health.messages import Notice
from server.log.events import EventLog, words
from server.operate.events import ModeChanged
from server.runs.results import RunEnded

QUEUED = 50
"""Notices that wait at most; what comes beyond them is left out."""
TIMEOUT_S = 5.0
"""For each step of one attempt [s]."""
ATTEMPTS = 6
"""For one notice, with pauses of FIRST_PAUSE, twice as long, ... between them: about half a minute."""
FIRST_PAUSE = 1.0
RETRY_MAX_S = 120.0
"""For one attempt and the pause before it [s]: what takes longer hangs."""
JSON = {"content-type": "application/json"}
TOLD: dict[Mode, Literal["fault", "e_stop"]] = {Mode.FAULT: "fault", Mode.E_STOP: "e_stop"}


class Webhook:
    """Posts to `url`. It follows no redirection, and takes neither proxies nor passwords from its environment."""

    def __init__(self, url: str, pause: float = FIRST_PAUSE) -> None:
        self._url, self._pause = url, pause
        self._host = urlsplit(url).hostname or ""
        """All of the address that is ever logged: the rest may be a secret."""
        self._queue: queue.SimpleQueue[Notice | None] = queue.SimpleQueue()
        self._failing, self._news = False, queue.SimpleQueue[str]()
        self._closing = threading.Event()
        self._client = httpx.Client(timeout=TIMEOUT_S, trust_env=False, headers={"user-agent": "tendril"})
        self.worker = SupervisedThread("webhook", self._run, RETRY_MAX_S)
        self.worker.start()

    def post(self, notice: Notice) -> None:
        """Let it be sent as soon as those before it are; never waits."""
        if self._queue.qsize() < QUEUED:
            self._queue.put(notice)
        else:
            self._fail(f"{QUEUED} notices wait for it already")

    def news(self) -> str:
        """What is to be said in the log, each once; "" where nothing is. To be asked now and then."""
        try:
            return self._news.get_nowait()
        except queue.Empty:
            return ""

    def close(self) -> None:
        """Send nothing more; what is under way may take as long as one attempt."""
        self._closing.set()
        self._queue.put(None)
        self.worker.stop(TIMEOUT_S)

    def _run(self) -> None:
        while True:
            self.worker.rest()
            notice = self._queue.get()
            self.worker.turn()
            if notice is None or self._closing.is_set():
                return self._client.close()
            self._send(notice)

    def _send(self, notice: Notice) -> None:
        """Try until it is taken, or often enough."""
        text, began, why = notice.model_dump_json(), time.monotonic(), ""
        for attempt in range(ATTEMPTS):
            if attempt and self._closing.wait(self._pause * 2 ** (attempt - 1)):
                return
            self.worker.turn()
            why = self._attempt(text)
            if not why:
                return self._recover()
        seconds = time.monotonic() - began
        self._fail(f"{why}; {ATTEMPTS} attempts within {seconds:.0f} s, the last notice was: {notice.text}")

    def _attempt(self, text: str) -> str:
        """Why it was not taken, "" if it was."""
        try:
            with self._client.stream("POST", self._url, content=text, headers=JSON) as answer:
                return "" if answer.is_success else f"it answered {answer.status_code}"
        except (httpx.HTTPError, httpx.InvalidURL, OSError) as error:
            return type(error).__name__

    def _fail(self, why: str) -> None:
        """Said once, until it works again."""
        if not self._failing:
            self._failing = True
            self._news.put(f"the webhook at {self._host} takes no notices: {why}")

    def _recover(self) -> None:
        if self._failing:
            self._failing = False
            self._news.put(f"the webhook at {self._host} takes notices again")


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
