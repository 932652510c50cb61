"""Recordings that no one pressed a button for, on a real rig."""

import os
import shutil
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from controller.link import RigClient
from controller.realtime.ring import CAPACITY
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from server.recorder import automatic
from tests.server.listed import listed
from tests.server.live_server import Live, Page, RigProcess, TestServer, free_environment, taken, wait_for
from tests.server.runs.test_runs import armed, ring, wait_run

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

ROW = record_dtype(Telemetry)


@pytest.fixture(autouse=True)
def shorter(monkeypatch: pytest.MonkeyPatch) -> None:
    """What follows a fault is recorded for 4 s, not for 10."""
    monkeypatch.setattr(automatic, "AFTER", 4.0)


@pytest.fixture
def server(shared_rig: RigProcess, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[TestServer]:
    """Its recorder is a process where a test kills that."""
    free_environment()
    found = TestServer(tmp_path, shared_rig.endpoint, apart="recorder_apart" in request.fixturenames)
    yield found
    found.close()


@pytest.fixture
def recorder_apart() -> None:
    """See `server`."""


def test_a_run_is_recorded_from_before_its_approach_to_its_end(server: TestServer) -> None:
    with armed(server) as (page, live):
        taken(page.run(json=ring(1.0)))
        wait_run(live, lambda state: state["state"] == "done")
        found = closed(page)
        run = page.get("/api/runs").json()[0]
    assert (found.name, found.reference, found.profile, found.gaps) == ("ring", "ring", "standard", 0)
    assert found.operator and found.settings == server.services.operator.settings
    assert run["recording"] == found.id
    mode = read_rows(server.services.folder.store.path(found.id))["mode"]
    assert mode[0] != Mode.TRACK and (mode == Mode.TRACK).sum() >= 3000 and mode[-1] == Mode.HOLD


def test_a_run_that_is_refused_or_not_to_be_recorded_leaves_none(server: TestServer) -> None:
    with armed(server) as (page, live):
        assert page.run(json={"reference": "no such thing"}).status_code != 200
        taken(page.run(json={**ring(0.5), "record": False}))
        wait_run(live, lambda state: state["state"] == "done")
        assert page.get("/api/runs").json()[0]["recording"] is None
        assert listed(page) == []


def test_a_stop_under_pressure_is_recorded_with_what_came_before_and_after_it(server: TestServer) -> None:
    with armed(server) as (page, live):
        stop(server, page, live)
        found = closed(page)
    assert found.name.startswith("fault: ")
    rows, last = read_rows(server.services.folder.store.path(found.id)), stops(server, found)[-1]
    assert rows["mode"][last - 1] == Mode.HOLD and rows["mode"][last] == Mode.E_STOP
    assert (np.diff(rows["tick"]) == 1).all()


def test_what_follows_is_recorded_of_a_second_stop_as_well(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second comes while the first one's recording goes on, on a machine that is slow, too."""
    monkeypatch.setattr(automatic, "AFTER", 12.0)
    with armed(server) as (page, live):
        armed_at = int(live.frames[-1]["tick"])  # what every operator begins with may be in the recording, too
        stop(server, page, live)
        for request, mode in (("clear", Mode.VENTED), ("arm", Mode.HOLD)):
            assert page.command(request).status_code == 200
            live.wait_mode(mode)
        stop(server, page, live)
        found = closed(page)
    tick = read_rows(server.services.folder.store.path(found.id))["tick"]
    assert sum(tick[row] > armed_at for row in stops(server, found)) == 2


def test_the_recording_of_a_run_has_what_follows_the_stop_that_ended_it(server: TestServer) -> None:
    with armed(server) as (page, live):
        taken(page.run(json=ring(6.0)))
        wait_run(live, lambda state: state["state"] == "running")
        stop(server, page, live)
        found = closed(page)
        assert page.get("/api/runs").json()[0]["recording"] == found.id
    assert len(stops(server, found)) == 1


def test_a_run_after_a_stop_has_a_recording_of_its_own(server: TestServer) -> None:
    with armed(server) as (page, live):
        stop(server, page, live)
        assert page.command("clear").status_code == 200
        assert page.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        taken(page.run(json=ring(0.5)))
        wait_run(live, lambda state: state["state"] == "done")
        wait_for(lambda: all(part.complete for part in two(page)), "their ends")
    run, fault = two(page)
    assert (run.reference, fault.reference) == ("ring", "") and fault.name.startswith("fault: ")
    tick = [read_rows(server.services.folder.store.path(part.id), ("tick",))["tick"] for part in (fault, run)]
    assert tick[0][-1] < tick[1][-1]


def copied_if_there(source: str, target: str) -> None:
    with suppress(FileNotFoundError):
        shutil.copy2(source, target)


def test_a_recording_of_a_killed_server_goes_on_without_a_missing_tick(
    server: TestServer, shared_rig: RigProcess
) -> None:
    page = server.operator()
    state = page.post("/api/recordings", json={"name": "two lives"}).json()
    wait_for(lambda: listed(page)[0]["rows"] > 500, "rows")
    folder = server.settings.state.parent / "after"
    # As a kill -9 would leave it, but for a draft that takes a file's place at that very moment.
    shutil.copytree(server.services.folder.store.folder, folder / "recordings", copy_function=copied_if_there)
    wait_for(lambda: server.services.recorder.state().rows > 3000, "ticks that the copy does not have")
    page.delete("/api/recordings/current")
    server.close()  # the rig obeys one server at a time
    later = TestServer(folder, shared_rig.endpoint)
    try:
        wait_for(lambda: later.services.recorder.state().recording, "the recording to go on")
        done = Recording.model_validate(later.operator().delete("/api/recordings/current").json())
        first = wait_for(
            lambda: (found := later.services.folder.store.find(state["id"])).recovered and found, "the repair"
        )
        parts = [read_rows(later.services.folder.store.path(id))["tick"] for id in (state["id"], done.id)]
    finally:
        later.close()
    assert (done.name, done.part_of, done.gaps, done.holes) == ("two lives", state["id"], 0, ())
    assert first.rows == len(parts[0])
    assert (np.diff(np.concatenate(parts)) == 1).all()


@pytest.mark.usefixtures("recorder_apart")
def test_a_recording_of_a_killed_writer_goes_on_without_a_missing_tick(server: TestServer) -> None:
    page, store = server.operator(), server.services.folder.store
    id = page.post("/api/recordings", json={"name": "two writers", "profile": "full"}).json()["id"]
    wait_for(lambda: listed(page)[0]["rows"] > 500, "rows")
    kill_recorder(server)
    wait_for(lambda: len(store.list()) == 2 and server.services.recorder.state().recording, "the second part")
    server.services.recorder.stop()  # on a busy machine all that took longer than a lease
    parts = sorted(store.list(), key=lambda part: part.started)
    assert [(part.name, part.part_of) for part in parts] == [("two writers", ""), ("two writers", id)]
    assert [part.gaps for part in parts] == [0, 0]
    in_one_piece(server, [part.id for part in parts])
    wait_for(lambda: all(found.complete or found.recovered for found in store.list()), "the repair")
    in_one_piece(server, [part.id for part in parts])
    log = [event.text for event in server.services.events.recent]
    assert any("the process that wrote it was killed" in line for line in log), log
    assert any(f"goes on after {id}" in line for line in log), log


@pytest.mark.usefixtures("recorder_apart")
def test_a_run_whose_writer_is_killed_is_recorded_to_its_end_and_no_longer(server: TestServer) -> None:
    with armed(server) as (page, live):
        taken(page.run(json=ring(6.0)))
        wait_for(lambda: server.services.recorder.state().rows > 500, "rows")
        kill_recorder(server)
        wait_run(live, lambda state: state["state"] == "done")
        wait_for(lambda: not server.services.recorder.state().recording and two(page)[0].complete, "the end")
    last, first = two(page)
    assert (last.part_of, first.part_of, last.gaps) == (first.id, "", 0)
    mode = in_one_piece(server, [first.id, last.id])["mode"]
    assert mode[0] != Mode.TRACK and (mode == Mode.TRACK).sum() >= 6000 and mode[-1] == Mode.HOLD


@pytest.mark.usefixtures("recorder_apart")
def test_a_recording_whose_writer_is_killed_as_it_ends_keeps_its_end(server: TestServer) -> None:
    page = server.operator()
    taken(page.post("/api/recordings", json={"name": "short"}))
    wait_for(lambda: server.services.recorder.state().rows > 500, "rows")
    recorder = server.services.recorder
    os.kill(recorder.pid, signal.SIGSTOP)  # it must not answer before it is killed
    with ThreadPoolExecutor(1) as pool:
        answer = pool.submit(page.delete, "/api/recordings/current")
        wait_for(lambda: recorder._stopping and recorder._asked, "the end that is asked for")
        kill_recorder(server)
        refused = answer.result()
    asked = server.services.rig.newest
    assert refused.status_code == 409 and "was killed" in refused.json()["detail"]
    wait_for(lambda: not server.services.recorder.state().recording and two(page)[0].complete, "the end")
    tick = in_one_piece(server, [part.id for part in reversed(two(page))])["tick"]
    assert asked is not None and tick[-1] > asked[0]["tick"]


def test_ticks_that_the_ring_lost_do_not_hide_those_that_it_holds() -> None:
    link, held = RigClient.__new__(RigClient), np.zeros(9000, ROW)
    held["tick"] = np.arange(50_000, 59_000)

    def replay(first: int, count: int) -> Any:
        return held[(held["tick"] >= first) & (held["tick"] < first + count)]

    link.replay = replay  # type: ignore[method-assign]
    assert link.replay_all(1000, 58_500)["tick"].tolist() == [*range(50_000, 58_500)]


def stop(server: TestServer, page: Page, live: Live) -> None:
    """E-STOP; this one is recorded, the one that every operator begins with is not."""
    server.settings.record_faults = True
    assert page.command("e_stop").status_code == 200
    live.wait_mode(Mode.E_STOP)
    wait_for(lambda: server.services.recorder.state().recording, "a recording of the stop")


def stops(server: TestServer, found: Recording) -> list[int]:
    """Rows of a recording that are the first of an E-STOP, after the last of which it goes on for `AFTER`."""
    rows = read_rows(server.services.folder.store.path(found.id), ("t_ns", "mode"))
    first = np.flatnonzero(np.diff((rows["mode"] == Mode.E_STOP).astype(int)) == 1) + 1
    assert len(first) and rows["t_ns"][-1] - rows["t_ns"][first[-1]] > (automatic.AFTER - 0.5) * 1e9
    return [int(row) for row in first]


def kill_recorder(server: TestServer) -> None:
    os.kill(server.services.recorder.pid, signal.SIGKILL)


def two(page: Page) -> list[Recording]:
    """Both parts once there are two, the last one first."""

    def look() -> list[Recording] | None:
        found = [Recording.model_validate(row) for row in listed(page)]
        return found if len(found) == 2 else None

    return cast(list[Recording], wait_for(look, "two parts"))


def in_one_piece(server: TestServer, ids: list[str]) -> dict[str, Any]:
    """Ticks and modes of all parts, among which none is missing and none is twice."""
    parts = [read_rows(server.services.folder.store.path(id), ("tick", "mode")) for id in ids]
    found = {name: np.concatenate([part[name] for part in parts]) for name in ("tick", "mode")}
    lost, newest = found["tick"][:-1][np.diff(found["tick"]) != 1], server.services.rig.newest
    late = len(lost) > 0 and newest is not None and newest[0]["tick"] - lost[0] >= CAPACITY
    assert not len(lost), f"ticks are missing after {lost}{' (a ring ago: a busy machine)' if late else ''}"
    return found


def closed(page: Page) -> Recording:
    """The only recording, once it has ended."""

    def look() -> Recording | None:
        found = [Recording.model_validate(row) for row in listed(page)]
        return found[0] if found and found[0].complete else None

    found = wait_for(look, "the end of the recording")
    assert isinstance(found, Recording)
    return found
