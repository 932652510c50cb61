"""What the page and the log are told of a recording that waits for its disk."""

import threading
from typing import Any

import pytest

from recordings.write.session import Session
from tests.server.live_server import Live, TestServer, wait_for


def logged(server: TestServer, text: str) -> bool:
    return any(text in event.text for event in list(server.services.events.recent))


def newest(live: Live) -> dict[str, Any]:
    """What the page was told last of the recording."""
    found: dict[str, Any] = next(text for text in reversed(live.texts) if text["type"] == "status")["recording"]
    return found


def test_page_and_log_say_that_it_waits_and_that_it_has_caught_up(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, takes, true = server.operator(), threading.Event(), Session.write
    id = page.post("/api/recordings", json={"name": "slow disk"}).json()["id"]

    def write(session: Session, rows: object) -> None:
        takes.wait()
        true(session, rows)  # type: ignore[arg-type]

    monkeypatch.setattr(Session, "write", write)
    try:
        with page.live() as live:
            said = live.wait("status", lambda message: message["recording"]["problem"])["recording"]
            assert said["recording"] and "the disk took nothing for 3 s: rows wait in memory" in said["problem"]
            wait_for(lambda: logged(server, said["problem"]), "a line in the log")
            assert "waits for the disk" in page.get("/healthz").json()["recorder"]["detail"]
            takes.set()
            wait_for(lambda: logged(server, f"recording {id} has caught up"), "another one")
            wait_for(lambda: not newest(live)["problem"], "a page without the sign")
            assert newest(live)["recording"]
    finally:
        takes.set()
    done = page.delete("/api/recordings/current").json()
    assert (done["id"], done["complete"], done["gaps"]) == (id, True, 0)
