"""The webhook against a real HTTP server: what it is told, when it fails, and that no one waits for it."""

import json
import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from pydantic import SecretStr, ValidationError

from controller.errors import sentence
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import Settings
from controller.system.event_bus import EventBus
from controller.system.scheduler import Scheduler
from server.access.lease import OperatorLease
from server.app.up import environment
from server.health.messages import Notice
from server.health.notices import ATTEMPTS, QUEUED, Notices, Webhook
from server.log.events import EventLog
from server.operate.detector import ChangeDetector
from server.operate.operator import Operator
from server.rig.client import Rig
from server.runs.messages import RunResult
from server.runs.results import Results
from server.settings import ServerSettings
from tests.server.live_server import TOKEN, RigProcess, TestServer, free_environment, taken, wait_for


class Receiver:
    """A web server that keeps what it is sent, and answers with `status` once `answers` is set."""

    def __init__(self) -> None:
        self.bodies: list[dict[str, Any]] = []
        self.heads: list[dict[str, str]] = []
        self.status, self.asked = 200, 0
        self.answers = threading.Event()
        self.answers.set()
        receiver = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = json.loads(self.rfile.read(int(self.headers["content-length"])))
                receiver.asked += 1
                receiver.answers.wait(60.0)
                if receiver.status == 200:
                    receiver.bodies.append(body)
                    receiver.heads.append({name.lower(): value for name, value in self.headers.items()})
                self.send_response(receiver.status)
                self.send_header("location", "/elsewhere")
                self.end_headers()

            def log_message(self, *_: Any) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/hook"
        self._thread = threading.Thread(target=self._server.serve_forever)
        self._thread.start()

    def close(self) -> None:
        self.answers.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    found = Receiver()
    yield found
    found.close()


@pytest.fixture
def hook(receiver: Receiver) -> Iterator[Webhook]:
    found = Webhook(receiver.url, pause=0.01)
    yield found
    receiver.answers.set()
    found.close()


def notice(text: str = "x") -> Notice:
    return Notice(event="fault", rig="twin", time=datetime.now(UTC), text=text, cause="tracking error")


def heard(hook: Webhook) -> str:
    return str(wait_for(hook.news, "news of the webhook"))


def test_a_stop_on_a_real_rig_is_posted_without_any_token(
    shared_rig: RigProcess, receiver: Receiver, tmp_path: Path
) -> None:
    free_environment()
    server = TestServer(tmp_path, shared_rig.endpoint, webhook=SecretStr(f"{receiver.url}?key=1"))
    try:
        page = server.operator()  # in VENTED
        for name in ("e_stop", "clear", "e_stop"):  # faster than anything looks
            taken(page.command(name))
        wait_for(lambda: len(receiver.bodies) >= 2, "the notices of both stops")
    finally:
        server.close()
    for body, head in zip(receiver.bodies, receiver.heads, strict=True):
        assert (body["event"], body["rig"], body["cause"]) == ("e_stop", "test", "operator")
        assert abs((datetime.now(UTC) - datetime.fromisoformat(body["time"])).total_seconds()) < 600
        assert TOKEN not in json.dumps([body, head]) and not {"cookie", "authorization"} & set(head)


def test_fault_and_the_end_of_a_run_are_told_once(receiver: Receiver, hook: Webhook, tmp_path: Path) -> None:
    rows, bus, lease = np.zeros(6, record_dtype(Telemetry)), EventBus(Scheduler()), OperatorLease()
    earlier = Results(tmp_path / "runs.json")
    earlier.add(result(7, "circle"))
    earlier.close()
    results = Results(tmp_path / "runs.json", bus.publish)
    Notices("twin", hook, EventLog(), bus)
    rig = cast(Rig, SimpleNamespace(boot=lambda: 7, met=7, trouble=""))
    detector = ChangeDetector(rig, lease, cast(Operator, SimpleNamespace(settings=Settings())), bus)
    rows["mode"] = [Mode.HOLD, Mode.FOLLOW, Mode.FAULT, Mode.FAULT, Mode.VENTED, Mode.HOLD]
    rows["cause"] = Cause.TRACKING_ERROR
    for part in np.split(rows, [3]):
        detector.rows(part)
    bus.deliver()
    results.add(result(8, "ring"))
    results.close()
    for _ in range(2):
        detector.look()
        bus.deliver()
    wait_for(lambda: len(receiver.bodies) == 2, "both notices")
    fault, run = receiver.bodies
    assert (fault["event"], fault["cause"], fault["run"]) == ("fault", "tracking error", None)
    assert (run["event"], run["run"]["id"], run["text"]) == ("run_end", 8, "rig twin: run ring stopped (by ann)")


def test_what_fails_is_tried_again_said_once_and_said_when_it_is_over(receiver: Receiver, hook: Webhook) -> None:
    receiver.status = 503
    hook.post(notice("first"))
    hook.post(notice("second"))
    text = heard(hook)
    assert "127.0.0.1 takes no notices: it answered 503" in text and "first" in text and "/hook" not in text
    wait_for(lambda: receiver.asked >= 2 * ATTEMPTS, "all attempts")
    assert hook.news() == ""
    receiver.status = 200
    hook.post(notice("third"))
    assert heard(hook).endswith("takes notices again")
    assert [body["text"] for body in receiver.bodies] == ["third"]


def test_a_redirection_is_not_followed_and_nobody_there_is_a_failure(receiver: Receiver, hook: Webhook) -> None:
    receiver.status = 302
    hook.post(notice())
    assert "302" in heard(hook)
    refusing = Webhook("http://127.0.0.1:9/", pause=0.01)
    refusing.post(notice())
    assert "ConnectError" in heard(refusing)
    refusing.close()


def test_a_receiver_that_does_not_answer_holds_up_nobody_and_fills_no_memory(receiver: Receiver, hook: Webhook) -> None:
    receiver.answers.clear()
    for n in range(QUEUED + 10):
        hook.post(notice(str(n)))  # returns at once: else the test ends by its own timeout
    assert f"{QUEUED} notices wait" in heard(hook)
    receiver.answers.set()
    wait_for(lambda: len(receiver.bodies) >= QUEUED, "those that waited")
    assert len(receiver.bodies) <= QUEUED + 2


@pytest.mark.parametrize(
    "url", ["ftp://x/secret", "file:///secret", "https://", "x/secret", "http://x:0/secret", "http://x:y/secret"]
)
def test_only_an_address_of_http_is_taken_and_a_refusal_does_not_show_it(url: str) -> None:
    with pytest.raises(ValidationError) as refused:
        ServerSettings(webhook=SecretStr(url))
    assert sentence(refused.value).startswith("webhook: must be an address http://HOST")
    assert "secret" not in sentence(refused.value)


def test_the_address_reaches_the_server_of_up_and_is_never_shown() -> None:
    settings = ServerSettings(webhook=SecretStr("https://hooks.example/secret"))
    assert environment(settings)["TENDRIL_WEBHOOK"] == "https://hooks.example/secret"
    assert "secret" not in repr(settings)


def result(id: int, name: str) -> RunResult:
    nothing = dict.fromkeys(("rmse", "max_error", "lag_deg_x", "lag_deg_y", "saturated_share", "on_time_share"))
    return RunResult(
        id=id,
        name=name,
        time=datetime.now(UTC),
        laps=1.0,
        state="stopped",
        reason="by ann",
        duration=2.0,
        recording=None,
        **nothing,
    )
