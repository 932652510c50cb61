"""The application as it is made and ended: the first request finds all of the start done, and no thread stays."""

import threading
from pathlib import Path

from server.app import app
from tests.controller.drivers.effort import lines_run
from tests.server.live_server import RigProcess, TestServer, key_file, wait_for


def test_routes_are_built_with_the_application_and_not_in_the_event_loop() -> None:
    made = app._api.__wrapped__()

    def look() -> None:
        for route in made.routes:
            route.matches(app.NOWHERE)

    assert lines_run(look) == lines_run(look)


def test_an_ended_server_leaves_no_thread(shared_rig: RigProcess, tmp_path: Path) -> None:
    before: set[threading.Thread] = set()
    for name in ("one that starts what all share", "another"):
        before = set(threading.enumerate())
        found = TestServer(tmp_path / name, shared_rig.endpoint, key_file(tmp_path))
        found.operator()
        found.close()
    wait_for(lambda: set(threading.enumerate()) <= before, "the end of its threads")
