"""The webhook: each notice is posted as JSON by a thread of its own: neither event loop nor request waits for it."""

import queue
import threading
import time
from urllib.parse import urlsplit

import httpx

from controller.system.thread import SupervisedThread
from server.health.messages import Notice

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
