"""A real rig process, a real server on a free port, and a page that speaks to it over real sockets."""

import base64
import faulthandler
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

import httpx
import numpy as np
from pydantic import SecretStr
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode, Request
from controller.schema.states import TRANSITIONS
from controller.system.keys import KEY_BYTES
from recordings.live.channel import RecorderSettings
from recordings.live.host import Host
from recordings.write.writer import Recorder
from server.app.app import create_app
from server.app.listening import address, listen
from server.app.run import uvicorn_server
from server.app.services import Services
from server.recorder.client import launch
from server.recorder.folder import Reader
from server.rig.planner import Planner
from server.settings import ServerSettings
from tests.waiting import WAIT_MAX_S, wait_for

TOKEN = "correct horse"
VIEWER_TOKEN = "battery staple"
ROW = record_dtype(Telemetry)
PATIENT = {"loop_gap": 0.4, "operator_timeout": 2.0, "server_hold": 1.5, "pump_hold": 1.5}
"""Limits of the rig under test: shared machines pause, and the page shares a process with its server."""

EXPLAINED = 20_000
"""Of what a rig that serves nobody has said at last [characters]."""

STILL = 12
"""Frames, a fifth of a second, in which a tip that rests moves by less than a millimetre."""

LATE = ("did not answer within", "does not answer", "was not answered within", "was silent")
"""What a server says where it heard nothing from the rig in time."""


def key_file(folder: Path) -> Path:
    """The same key for every rig and server under test, in a file in `folder`."""
    path = folder / "test.key"
    path.touch(mode=0o600)
    path.write_text(base64.b64encode(b"k" * KEY_BYTES).decode())
    return path


class RigProcess:
    """`python -m controller.realtime`, with the endpoint kept over restarts; what it says is in `log`."""

    at: ClassVar[dict[str, "RigProcess"]] = {}
    """The newest by its endpoint."""

    def __init__(self, folder: Path) -> None:
        self._folder, self.log = folder, folder / "rig.log"
        self.endpoint = "tcp/127.0.0.1:0"
        self.start()

    def start(self) -> None:
        ready = self._folder / "ready.json"
        ready.unlink(missing_ok=True)
        settings = {
            "rig": "test",
            "listen": self.endpoint,
            "ready": str(ready),
            "folder": str(self._folder),
            "key_file": str(key_file(self._folder)),
            "parameters": {"limits": PATIENT},
        }
        command = [sys.executable, "-X", "faulthandler", "-m", "controller.realtime", json.dumps(settings)]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(command, stderr=log)
        wait_for(lambda: ready.exists() or self.process.poll() is not None, "the rig")
        assert self.process.poll() is None, f"the rig died at its start: {self.log.read_text()}"
        said = json.loads(ready.read_text())
        self.endpoint, self.boot = said["endpoint"], said["boot"]
        self.at[self.endpoint] = self

    def explain(self) -> str:
        """Why it serves nobody: it is aborted, says where each thread stands, and another one takes its place."""
        ended = self.process.poll()
        for number in (signal.SIGABRT, signal.SIGCONT):
            self.process.send_signal(number)
        self.process.wait()
        said = self.log.read_text()[-EXPLAINED:]
        self.start()
        return f"the rig {'was there' if ended is None else f'had ended with {ended}'} and says\n{said}"

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def stop(self) -> None:
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()


class Live:
    """One live socket; a thread keeps what it hears, and sends presence while asked to."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.texts: list[dict[str, Any]] = []
        self.frames: list[np.ndarray] = []
        self.plots: list[bytes] = []
        self._present = threading.Event()
        self._closed = threading.Event()
        self._threads = [threading.Thread(target=job) for job in (self._hear, self._tell)]
        for thread in self._threads:
            thread.start()

    def send(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def operate(self, present: bool = True) -> None:
        (self._present.set if present else self._present.clear)()

    def wait(self, kind: str, which: Callable[[dict[str, Any]], bool] = lambda message: True) -> dict[str, Any]:
        return wait_for(lambda: next((m for m in self.texts if m["type"] == kind and which(m)), None), kind)

    def wait_mode(self, mode: Mode) -> np.void:
        return wait_for(lambda: self.frames and self.frames[-1]["mode"] == mode and self.frames[-1], mode.name)

    def wait_still(self) -> None:
        """Until the arm rests: one rig serves many tests, and the one before may have left it swinging."""

        def rests() -> bool:
            tips = [frame["p_hat"] for frame in self.frames[-STILL:]]
            return len(tips) == STILL and bool(np.ptp(tips, axis=0).max() < 1e-3)

        wait_for(rests, "the arm at rest")

    def close(self) -> None:
        self._closed.set()
        self.socket.close()
        for thread in self._threads:
            thread.join()

    def _hear(self) -> None:
        try:
            for message in self.socket:
                if isinstance(message, str):
                    self.texts.append(json.loads(message))
                elif message[0] == 1:
                    self.frames.append(np.frombuffer(message, ROW, offset=8)[0])
                else:
                    self.plots.append(message)
        except ConnectionClosed:
            pass

    def _tell(self) -> None:
        n = 0
        while not self._closed.wait(0.05):
            n += 1
            if self._present.is_set():
                try:
                    self.send(type="presence", n=n)
                except ConnectionClosed:
                    return


def taken(answer: httpx.Response) -> httpx.Response:
    """The answer, which is no refusal: else its reason is shown."""
    assert answer.is_success, f"{answer.status_code}: {answer.text}"
    return answer


def _in_time(ask: Callable[[], httpx.Response], late: list[httpx.Response]) -> httpx.Response:
    """The first answer that is not that the rig was too late, of five; those before it go to `late`."""
    for _ in range(4):
        answer = ask()
        if answer.status_code != 503 or not any(text in answer.text for text in LATE):
            return answer
        late.append(answer)
    return ask()


class Page(httpx.Client):
    """One browser: its own cookies."""

    def __init__(self, url: str) -> None:
        super().__init__(base_url=url, trust_env=False, timeout=WAIT_MAX_S)

    def sign_in(self, token: str = TOKEN) -> "Page":
        assert self.post("/api/session", json={"token": token}).status_code == 200
        return self

    def operate(self) -> "Page":
        assert self.post("/api/lease").status_code == 200
        return self

    def command(self, request: str, **more: Any) -> httpx.Response:
        """The answer; asked again, as an operator would, where the machine was too busy for one in time.

        What was asked for twice may have been obeyed the first time: refused in the mode it leads to, it is taken.
        """
        late: list[httpx.Response] = []
        answer = _in_time(lambda: self.post("/api/command", json={"request": request, **more}), late)
        known = Request.__members__.get(request.upper())
        leads_to = {then[known] for then in TRANSITIONS.values() if known in then}
        if late and answer.status_code == 409 and answer.json().get("mode") in leads_to:
            return httpx.Response(200, json=answer.json() | {"accepted": True}, request=answer.request)
        return answer

    def run(self, json: Any) -> httpx.Response:
        """The answer to a run; asked again where the rig was too busy to answer in time."""
        return _in_time(lambda: self.post("/api/run", json=json), [])

    def connect(self, path: str, **more: Any) -> ClientConnection:
        cookies = "; ".join(f"{name}={value}" for name, value in self.cookies.items())
        headers = {"Cookie": cookies, **more.pop("headers", {})}
        url = str(self.base_url).replace("http", "ws").rstrip("/") + path
        return connect(url, additional_headers=headers, proxy=None, max_size=None, **more)

    @contextmanager
    def live(self) -> Iterator[Live]:
        found = Live(self.connect("/ws/live"))
        try:
            yield found
        finally:
            found.close()


PLANNER, READER = Planner(), Reader(nice=0)
"""One for all servers of a test process, with which it ends: each would take a second to start. The reader is as urgent
as all else here: with niceness it would wait for the tests beside it.
"""
PLANNER.stop = READER.stop = lambda timeout=0.0: True  # type: ignore[method-assign]


class TestServer:
    """The server in a thread of this process, so that tests can also look inside, and its recorder in another one."""

    __test__ = False
    recorder: Recorder
    """The one that its recorder's client asks."""

    def __init__(self, folder: Path, endpoint: str, key: Path | None = None, apart: bool = False, **more: Any) -> None:
        """`apart`: the recorder is a process, as it should be, and takes a second to start."""
        listening = listen("127.0.0.1", 0)
        self.settings = ServerSettings(
            port=listening.getsockname()[1],
            endpoint=endpoint,
            key_file=key or key_file(folder),
            rig="test",
            recordings=folder / "recordings",
            state=folder / "state",
            token=SecretStr(TOKEN),
            viewer_token=SecretStr(VIEWER_TOKEN),
            light_scene=True,
            record_faults=False,  # every operator begins with an E-STOP
            **{"control_lapse": 60.0} | more,  # a page that only posts keeps control on a busy machine, too
        )
        self.services = Services(
            self.settings, planner=PLANNER, reader=READER, launch_recorder=launch if apart else self._host
        )
        self.app = create_app(self.services)
        self.url = address(self.settings, listening)
        self._server = uvicorn_server(self.app, self.settings, _at_once, lambda: None)
        self._thread = threading.Thread(target=self._server.run, args=([listening],))
        self._thread.start()
        wait_for(lambda: self._server.started, "the server")
        self._pages: list[Page] = []

    def _host(self, settings: RecorderSettings, refill: bool) -> None:
        host = Host(settings, refill)
        self.recorder = host.recorder
        threading.Thread(target=host.run, name="recorder-host", daemon=True).start()

    def page(self) -> Page:
        """A browser that is not signed in yet."""
        self._pages.append(Page(self.url))
        return self._pages[-1]

    def operator(self) -> Page:
        """A signed-in browser that holds the lease, with the rig connected and vented."""
        page = self.page().sign_in().operate()
        try:
            wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
        except AssertionError as error:
            rig, health = RigProcess.at.get(self.settings.endpoint), page.get("/api/health").text
            faulthandler.dump_traceback()
            raise AssertionError(f"{error}: {health}; {rig.explain() if rig else ''}") from error
        assert page.command("e_stop").status_code == 200
        assert page.command("clear").status_code == 200
        return page

    def close(self) -> None:
        for page in self._pages:
            page.close()
        self._server.should_exit = True
        self._thread.join()
        assert not self._server.lifespan.error_occurred, "the server did not end in order: see its log"


async def _at_once() -> None:
    """The rig need not come to rest before these servers end: it serves the next one."""


def rigless(folder: Path) -> Iterator[TestServer]:
    """For a fixture: a server that no rig has ever spoken to."""
    free_environment()
    found = TestServer(folder, "tcp/127.0.0.1:9")
    yield found
    found.close()


def free_environment() -> None:
    """No setting of the machine may reach the servers under test."""
    for name in [name for name in os.environ if name.startswith("TENDRIL_")]:
        del os.environ[name]
