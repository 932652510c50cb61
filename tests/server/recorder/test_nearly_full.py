"""A disk that is nearly full, and a quota that one recording is larger than: what the operator is told."""

from pathlib import Path

import pytest

from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.store.quota import bytes_on_disk
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.log.events import EventLog
from server.recorder.quota_watch import QuotaWatch
from tests.recordings.synthetic import rig_info, telemetry_rows
from tests.server.live_server import RigProcess, TestServer, free_environment, wait_for

PLENTY = 1 << 60


def logged(server: TestServer, text: str) -> str:
    return next((event.text for event in list(server.services.events.recent) if text in event.text), "")


def watching(server: TestServer, store: Store, most: int | None, events: EventLog) -> QuotaWatch:
    """Of another folder than the server's."""
    return QuotaWatch(store, most, server.services.recorder, server.services.review, events, Scheduler())


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


def test_where_the_quota_has_no_room_it_ends_the_recording_and_erases_none(
    shared_rig: RigProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.app.services.QUOTA_S", 0.5)
    free_environment()
    server = TestServer(tmp_path, shared_rig.endpoint, recordings_quota=1000)
    try:
        page = server.operator()
        id = page.post("/api/recordings", json={"name": "too long"}).json()["id"]
        with page.live() as live:
            told = live.wait("status", lambda message: message["recording"]["problem"])["recording"]["problem"]
        assert "nothing is recorded" in told and "1e-06 GB (TENDRIL_RECORDINGS_QUOTA)" in told
        wait_for(lambda: logged(server, told), "a line in the log")
        wait_for(lambda: logged(server, f"recording {id} was ended"), "the end of the recording")
        [left] = page.get("/api/recordings").json()
        assert left["id"] == id and left["complete"]
        refused = page.post("/api/recordings", json={"name": "no room"})
        assert (refused.status_code, refused.json()["detail"]) == (409, told)
        assert not page.get("/healthz").json()["recorder"]["ok"]
        wait_for(lambda: page.delete(f"/api/recordings/{id}").is_success, "it is closed")
        wait_for(lambda: logged(server, "recordings may begin again"), "room")
        assert page.post("/api/recordings", json={"name": "again"}).is_success
        assert [one["id"] for one in page.get("/api/recordings?deleted=true").json()] == [id]
    finally:
        server.close()


async def test_what_the_quota_deletes_is_named_and_can_be_restored(server: TestServer, tmp_path: Path) -> None:
    folder = tmp_path / "others"
    store, recorder = Store(folder), Recorder(folder)
    ids = []
    for name in ("a", "b"):
        ids.append(recorder.start(name, rig_info(), Settings()).id)
        recorder.rows(telemetry_rows(300))
        recorder.stop()
    recorder.close()
    events = EventLog()
    watch = watching(server, store, bytes_on_disk(store, ids[1]), events)
    for _ in range(2):
        await watch.keep()
    assert [one.id for one in store.list()] == [ids[1]]
    [told] = [event.text for event in events.recent]
    assert ids[0] in told and "restored" in told
    assert store.restore(ids[0]).complete


async def test_a_folder_that_is_gone_for_a_moment_costs_no_recording(
    server: TestServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, aside = tmp_path / "others", tmp_path / "unmounted"
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
    await watching(server, store, None, events).keep()
    assert len(store.list()) == 3 and not events.recent
