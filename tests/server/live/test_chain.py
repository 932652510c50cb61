"""The whole chain: page, server, link, rig process, twin, and back."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from controller.schema.modes import Cause, Mode
from tests.server.live_server import ROW, RigProcess, TestServer, taken, wait_for

pytestmark = pytest.mark.alone

AIM = (0.17, 0.13)


def test_arm_follow_move_and_e_stop(server: TestServer) -> None:
    page = server.operator()
    with page.live() as live:
        hello = live.wait("hello")
        size = sum(8 if f["type"] != "float32" else 4 for f in hello["layout"] if not f["shape"])
        assert 0 < size < ROW.itemsize
        live.operate()
        assert taken(page.command("arm")).json()["accepted"]
        start = live.wait_mode(Mode.HOLD)["p_meas"].copy()
        live.send(type="target", id=7, x=AIM[0], y=AIM[1], start=True)
        reply = live.wait("reply", lambda m: m["id"] == 7)["reply"]
        assert (reply["accepted"], reply["mode"]) == (True, Mode.FOLLOW)
        wait_for(lambda: np.hypot(*(live.frames[-1]["p_meas"] - AIM)) < 0.003, "the tip at the target")
        assert np.hypot(*(start - AIM)) > 0.05
        live.send(type="target", id=8, x=AIM[0], y=AIM[1] - 0.02)
        live.wait("reply", lambda m: m["id"] == 8)
        wait_for(lambda: live.frames[-1]["p_meas"][1] < AIM[1] - 0.015, "the tip moving on")
        viewer = server.page().sign_in()
        assert taken(viewer.command("e_stop")).json()["mode"] == Mode.E_STOP
        stopped = live.wait_mode(Mode.E_STOP)
        assert not stopped["u"].any()
        assert not stopped["pressure_cmd"].any()
        assert page.command("arm").status_code == 409
        live.send(type="target", id=9, x=AIM[0], y=AIM[1], start=True)
        assert not live.wait("reply", lambda m: m["id"] == 9)["reply"]["accepted"]
        texts = [m["text"] for m in live.texts if m["type"] == "event"]
        assert any("e-stop" in text for text in texts), "the log says who"


def test_a_silent_operator_is_held_and_moves_only_after_a_fresh_press(server: TestServer) -> None:
    page = server.operator()
    with page.live() as live:
        live.operate()
        page.command("arm")
        assert page.command("follow", target=AIM).json()["mode"] == Mode.FOLLOW
        live.wait_mode(Mode.FOLLOW)
        live.operate(present=False)
        assert live.wait_mode(Mode.HOLD)["cause"] == Cause.OPERATOR_LOST
        live.operate()
        live.send(type="target", id=1, x=0.2, y=0.0)
        live.wait("reply", lambda m: m["id"] == 1)
        assert live.frames[-1]["mode"] == Mode.HOLD
        live.send(type="target", id=2, x=0.2, y=0.0, start=True)
        live.wait_mode(Mode.FOLLOW)


def test_giving_the_lease_back_holds_the_motion(server: TestServer) -> None:
    page, other = server.operator(), server.page().sign_in()
    with page.live() as live, other.live() as their_live:
        live.operate()
        their_live.operate()
        page.command("arm")
        page.command("follow", target=AIM)
        live.wait_mode(Mode.FOLLOW)
        assert other.post("/api/lease").status_code == 409
        page.delete("/api/lease")
        assert other.post("/api/lease").json()["mine"]
        live.wait_mode(Mode.HOLD)
        assert their_live.wait("status", lambda m: m["lease"]["mine"])


def test_settings_reach_the_loop_and_survive_the_server(server: TestServer) -> None:
    page = server.operator()
    changed = page.patch("/api/settings", json={"changes": {"law": 0, "sensed": 0b1000100000, "K_P": [0.5, 0.6]}})
    assert changed.json()["K_P"] == [0.5, 0.6]
    with page.live() as live:
        wait_for(lambda: live.frames and live.frames[-1]["sensed"] == 0b1000100000, "the sensors switched")
        assert live.frames[-1]["law"] == 0
        assert live.wait("status")["settings"]["K_P"] == [0.5, 0.6]
    assert '"K_P":[0.5,0.6]' in (server.settings.state / "settings-test.json").read_text()


def test_settings_that_cannot_be_kept_are_in_force_all_the_same(server: TestServer) -> None:
    page = server.operator()
    server.settings.state.rename(server.settings.state.with_name("elsewhere"))
    with page.live() as live:
        assert page.patch("/api/settings", json={"changes": {"K_P": [0.2, 0.2]}}).json()["K_P"] == [0.2, 0.2]
        live.wait("event", lambda m: "will not outlive" in m["text"])


def test_recording_holds_every_tick_and_opens_for_sessions_only(server: TestServer) -> None:
    page = server.operator()
    assert page.delete("/api/recordings/current").status_code == 409
    state = page.post("/api/recordings", json={"name": "first try"}).json()
    assert state["recording"]
    assert page.post("/api/recordings", json={}).status_code == 409
    wait_for(lambda: server.services.recorder.state().rows > 500, "rows in the recording")
    sizes: set[int] = set()
    while len(sizes) < 8:  # it grows while it is read: every answer is whole all the same
        sizes.add(len(taken(page.get(f"/api/recordings/{state['id']}.rrd")).content))
        time.sleep(0.1)  # as often as it grows: a fast machine asked more than a page may
    done = page.delete("/api/recordings/current").json()
    assert (done["name"], done["gaps"], done["complete"]) == ("first try", 0, True)
    assert [r["id"] for r in page.get("/api/recordings").json()] == [done["id"]]
    file = page.get(f"/api/recordings/{done['id']}.rrd")
    assert (file.status_code, len(file.content)) == (200, done["bytes"])
    assert file.content[:4] == b"RRF2"
    assert page.get("/api/recordings/nothing.rrd").status_code == 404
    assert page.get("/api/recordings/..%2F..%2Fsecrets.rrd").status_code in (404, 422)


@pytest.fixture
def mortal(tmp_path: Path) -> Iterator[RigProcess]:
    """A rig of its own, which the test may kill."""
    rig = RigProcess(tmp_path)
    yield rig
    rig.stop()


def test_a_killed_rig_is_reported_and_comes_back_vented(mortal: RigProcess, tmp_path: Path) -> None:
    server = TestServer(tmp_path, mortal.endpoint)
    try:
        page = server.operator()
        with page.live() as live:
            live.operate()
            page.patch("/api/settings", json={"changes": {"K_P": [0.5, 0.5]}})
            page.command("arm")
            live.wait_mode(Mode.HOLD)
            mortal.kill()
            live.wait("status", lambda m: not m["health"]["rig_connected"])
            live.texts.clear()
            mortal.start()
            live.wait("status", lambda m: m["health"]["rig_connected"] and m["rig"]["boot"] == mortal.boot)
            assert live.wait_mode(Mode.VENTED)["request_n"] == 0
            assert page.command("hold").status_code == 409
            assert live.frames[-1]["mode"] == Mode.VENTED
            assert page.command("arm").json()["mode"] == Mode.HOLD
            assert page.get("/api/settings").json()["K_P"] == [0.5, 0.5]
    finally:
        server.close()


def test_a_stop_that_was_pressed_while_the_rig_was_gone_stops_it_when_it_is_back(
    mortal: RigProcess, tmp_path: Path
) -> None:
    server = TestServer(tmp_path, mortal.endpoint)
    try:
        page = server.operator()
        with page.live() as live:
            mortal.kill()
            live.wait("status", lambda m: not m["health"]["rig_connected"])
            gone = page.command("e_stop")
            assert gone.status_code == 503
            assert "rig" in gone.json()["detail"]
            mortal.start()
            live.wait_mode(Mode.E_STOP)
            stopper = server.services.operator.stopper
            wait_for(lambda: not stopper.waits, "the rig's answer, which comes once its latch is on disk")
            assert page.command("arm").status_code == 409
            assert page.command("clear").json()["mode"] == Mode.VENTED
            assert page.command("arm").json()["mode"] == Mode.HOLD
    finally:
        server.close()


def test_a_server_that_starts_again_changes_nothing(shared_rig: RigProcess, tmp_path: Path) -> None:
    """Stopped while it records and the rig holds, it leaves a whole file; the next one arms and moves nothing."""
    first = TestServer(tmp_path, shared_rig.endpoint)
    page = first.operator()
    page.patch("/api/settings", json={"changes": {"K_P": [0.7, 0.7]}})
    page.command("arm")
    page.post("/api/recordings", json={})
    wait_for(lambda: first.services.recorder.state().rows > 300, "rows in the recording")
    first.close()
    second = TestServer(tmp_path, shared_rig.endpoint)
    try:
        page = second.page().sign_in()
        assert [r["complete"] for r in page.get("/api/recordings").json()] == [True]
        history = second.services.history
        wait_for(lambda: history.count > 1000, "a second of telemetry")
        row = history.newest[0]
        assert (row["mode"], row["request_cause"]) == (Mode.HOLD, Cause.NONE)
        wait_for(lambda: history.newest[0]["server_age"] < 0.2, "the heartbeat of the new server")
        assert history.newest[0]["request_n"] == row["request_n"]
        assert page.get("/api/settings").json()["K_P"] == [0.7, 0.7]
        assert len(page.get("/api/workspace").json()["points"]) > 100
    finally:
        second.close()
