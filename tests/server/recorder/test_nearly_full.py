"""A disk that is nearly full, and a quota that one recording is larger than: what the operator is told."""

from pathlib import Path

import pytest

from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.store.quota import enforce, too_large
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.log.events import EventLog
from server.recorder.quota_watch import QuotaWatch
from tests.recordings.synthetic import batches, rig_info, telemetry_rows
from tests.server.live_server import TestServer, wait_for

PLENTY = 1 << 60


def logged(server: TestServer, text: str) -> str:
    return next((event.text for event in list(server.services.events.recent) if text in event.text), "")


def test_a_recording_is_refused_with_folder_room_and_bound(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    page, folder = server.operator(), server.services.folder.store.folder
    monkeypatch.setattr("recordings.write.session.DISK_FREE_MIN", PLENTY)
    answer = page.post("/api/recordings", json={"name": "no room"})
    told = answer.json()["detail"]
    assert answer.status_code == 409
    assert "nearly full" in told and str(folder) in told and "MiB are free" in told
    assert f"at least {PLENTY >> 20} MiB" in told
    assert told[:190] in logged(server, "start recording refused")
    assert page.get("/api/recordings").json() == []


def test_one_that_the_disk_ends_says_so_in_log_and_state(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    page = server.operator()
    id = page.post("/api/recordings", json={"name": "too long"}).json()["id"]
    wait_for(lambda: server.services.recorder.state().rows > 200, "rows")
    monkeypatch.setattr("recordings.write.session.DISK_FREE_MIN", PLENTY)
    with page.live() as live:
        said = live.wait("status", lambda message: message["recording"]["problem"])["recording"]
    assert not said["recording"] and said["id"] == id
    for part in ("ended by itself", "nearly full", str(server.services.folder.store.folder), f"{PLENTY >> 20} MiB"):
        assert part in said["problem"]
    line = wait_for(lambda: logged(server, "ended by itself"), "a line in the log")
    assert line == said["problem"]
    [left] = page.get("/api/recordings").json()
    assert not left["complete"] and left["rows"] > 200


async def test_a_quota_smaller_than_one_recording_keeps_the_newest_and_says_so(tmp_path: Path) -> None:
    store, recorder = Store(tmp_path), Recorder(tmp_path)
    ids = []
    for name in ("a", "b"):
        ids.append(recorder.start(name, rig_info(), Settings()).id)
        for batch in batches(telemetry_rows(300), 100):
            recorder.rows(batch)
        recorder.stop()
    recorder.close()
    events = EventLog()
    watch = QuotaWatch(store, 1000, events, Scheduler())
    await watch.keep()
    await watch.keep()
    assert [one.id for one in store.list()] == [ids[1]] and enforce(store, 1000) == []
    assert too_large(store, 1000) == store.find(ids[1])
    told = [event.text for event in events.recent]
    assert len(told) == 2 and ids[0] in told[0] and ids[1] in told[1]
    assert "1e-06 GB" in told[1] and "stays" in told[1]


async def test_a_folder_that_is_gone_for_a_moment_costs_no_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, aside = tmp_path / "recordings", tmp_path / "unmounted"
    recorder = Recorder(folder)
    for name in ("a", "b", "c"):
        recorder.start(name, rig_info(), Settings())
        recorder.rows(telemetry_rows(100))
        recorder.stop()
    recorder.close()
    true = QuotaWatch._most

    def gone(watch: QuotaWatch) -> int | None:
        folder.rename(aside)
        try:
            return true(watch)
        finally:
            aside.rename(folder)

    monkeypatch.setattr(QuotaWatch, "_most", gone)
    store, events = Store(folder), EventLog()
    await QuotaWatch(store, None, events, Scheduler()).keep()
    assert len(store.list()) == 3 and not events.recent
