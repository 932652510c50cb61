"""SIGTERM to a server that moves the rig: real processes, and the rig's own ring as the judge."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from controller.realtime.ring import find_ring
from controller.schema.modes import Cause, Mode
from recordings.read.reader import read_log, read_rows
from recordings.store.store import Store
from server.app.ready import ServerReady
from tests.server.live_server import Page, RigProcess, free_environment, key_file, wait_for

pytestmark = pytest.mark.alone


class Server:
    """`python -m server`, as `tendril up` and systemd run it."""

    def __init__(self, folder: Path, endpoint: str) -> None:
        ready = folder / "server.json"
        self.recordings = folder / "recordings"
        given = {
            "port": "0",
            "endpoint": endpoint,
            "rig": "test",
            "key_file": str(key_file(folder)),
            "state": str(folder / "state"),
            "recordings": str(self.recordings),
            "light_scene": "1",
        }
        environment = os.environ | {f"TENDRIL_{name.upper()}": value for name, value in given.items()}
        self.process = subprocess.Popen([sys.executable, "-m", "server.app", str(ready)], env=environment)
        wait_for(lambda: ready.exists() or self.process.poll() is not None, "the server")
        self.url, self.token = ServerReady.model_validate_json(ready.read_bytes()).url.split("/?token=")

    @contextmanager
    def operator(self) -> Iterator[Page]:
        with Page(self.url) as page:
            assert page.post("/api/session", json={"token": self.token}).status_code == 200
            page.operate()
            wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
            yield page


@contextmanager
def running(folder: Path) -> Iterator[tuple[RigProcess, Server]]:
    free_environment()
    rig = RigProcess(folder)
    server = None
    try:
        server = Server(folder, rig.endpoint)
        yield rig, server
    finally:
        if server is not None:
            server.process.kill()
            server.process.wait()
        rig.stop()


def test_a_server_ended_while_it_tracks_vents_tells_everyone_and_closes_the_recording(
    tmp_path: Path,
) -> None:
    with running(tmp_path) as (rig, server), server.operator() as page, page.live() as live:
        live.operate()
        assert page.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        assert page.run(json={"reference": "circle_0.25hz", "laps": None}).status_code == 200
        live.wait_mode(Mode.TRACK)
        ring = find_ring("test", tmp_path)
        server.process.send_signal(signal.SIGTERM)
        live.wait("event", lambda message: "shuts down: the rig comes to rest" in message["text"])
        follow = page.command("follow", target=[0.2, 0.05])
        assert follow.status_code == 409 and "shutting down" in json.dumps(follow.json())
        assert server.process.wait(60) == 0
        last = ring.newest()
        assert last is not None and (last["mode"], last["cause"]) == (Mode.VENTED, Cause.RESTED)
        assert not last["pressure_cmd"].any()
        assert rig.process.poll() is None, "the rig itself goes on"
        modes = ring.read(0, ring.head)[1]["mode"]
        entered = modes[np.flatnonzero(np.diff(modes, prepend=-1))].tolist()
        assert entered[entered.index(Mode.TRACK) :] == [Mode.TRACK, Mode.REST, Mode.VENTED]
        live.wait_mode(Mode.VENTED)  # the page saw it to the end
    [recording] = Store(server.recordings).list()
    assert (recording.complete, recording.recovered, recording.gaps) == (True, False, 0)
    path = Store(server.recordings).path(recording.id)
    rows = read_rows(path)
    assert Mode.REST in rows["mode"] and (np.diff(np.sort(rows["tick"])) == 1).all()
    assert any("the server shuts down" in text for _, _, text in read_log(path))


def test_a_server_with_nothing_to_vent_ends_at_once_and_well(tmp_path: Path) -> None:
    with running(tmp_path) as (_, server), server.operator():
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(60) == 0


def test_a_server_ended_as_it_says_that_it_is_ready_ends_well(tmp_path: Path) -> None:
    free_environment()
    server = Server(tmp_path, "tcp/127.0.0.1:9")
    server.process.send_signal(signal.SIGTERM)
    assert server.process.wait(60) == 0
