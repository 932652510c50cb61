"""The application as it is made and ended: the first request finds all of the start done, and no thread stays."""

import sys
import threading
import traceback
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
        before = _threads()
        found = TestServer(tmp_path / name, shared_rig.endpoint, key_file(tmp_path))
        found.operator()
        found.close()
    try:
        wait_for(lambda: _threads() <= before, "the end of its threads")
    except AssertionError as error:
        raise AssertionError(f"{error}: {_where(_threads() - before)}") from error


def _threads() -> set[threading.Thread]:
    """Those that Python started. It also lists every thread of zenoh's that ever wrote to the log here, for good."""
    return {thread for thread in threading.enumerate() if not isinstance(thread, threading._DummyThread)}


def _where(threads: set[threading.Thread]) -> str:
    frames = {thread.name: sys._current_frames().get(thread.ident or 0) for thread in threads}
    ended = ["has ended meanwhile"]  # without a frame, format_stack would show our own
    stacks = {name: traceback.format_stack(frame) if frame else ended for name, frame in frames.items()}
    return "; ".join(f"{name}: {''.join(lines[-4:])}" for name, lines in stacks.items())
