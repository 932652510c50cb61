"""A server that is killed while it records: its recorder goes on, and the next server finds it at work."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from recordings.store.store import Store
from server.recorder import automatic
from tests.server.live_server import RigProcess, TestServer, free_environment, wait_for

pytestmark = [pytest.mark.process, pytest.mark.keyed()]


def killed_while_recording(folder: Path, endpoint: str, name: str) -> str:
    """The id of what it records."""
    program = [sys.executable, "-m", "tests.server.recorder.record_until_killed", folder, endpoint, name]
    with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout
        id = server.stdout.readline().strip()
        server.kill()
    return id


def test_a_recording_goes_on_without_its_server_and_the_next_one_ends_it(
    shared_rig: RigProcess, tmp_path: Path
) -> None:
    free_environment()
    id = killed_while_recording(tmp_path, shared_rig.endpoint, "by hand")
    store = Store(tmp_path / "recordings")
    rows = store.find(id).rows
    wait_for(lambda: store.find(id).rows > rows + 1000, "rows without a server")
    assert store.broken() == ()
    server = TestServer(tmp_path, shared_rig.endpoint, apart=True)
    try:
        state = wait_for(lambda: (found := server.services.recorder.state()).recording and found, "the recording")
        wait_for(lambda: any("goes on" in event.text for event in server.services.events.recent), "the log")
        page = server.page().sign_in().operate()  # commands nothing: the rig keeps to the killed server for 2 s
        done = Recording.model_validate(page.delete("/api/recordings/current").json())
        log = [event.text for event in server.services.events.recent]
    finally:
        server.close()
    assert (state.id, done.id, done.part_of, done.gaps, done.complete) == (id, id, "", 0, True)
    assert (np.diff(read_rows(store.path(id), ("tick",))["tick"]) == 1).all()
    assert f"recording {id} goes on: the server that began it was killed" in log


def test_that_of_a_fault_ends_by_itself_at_the_next_server(
    shared_rig: RigProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free_environment()
    monkeypatch.setattr(automatic, "AFTER", 1.0)
    id = killed_while_recording(tmp_path, shared_rig.endpoint, "fault: as if")
    server = TestServer(tmp_path, shared_rig.endpoint, apart=True)
    try:
        wait_for(lambda: server.services.folder.store.find(id).complete, "its end")
        process = server.services.recorder.pid
    finally:
        server.close()
    wait_for(lambda: not Path(f"/proc/{process}").exists(), "the recorder's end, with its last server")
    assert len(Store(tmp_path / "recordings").list()) == 1
