"""The live socket: malformed messages, slow viewers, history and the log."""

import contextlib
import json
import socket
import time

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from server.live.hub import VIEWERS_ALL_BEATS_MAX
from server.plots.messages import CHANNELS_MAX
from server.rig.channels import CHANNELS
from tests.server.live_server import ROW, TestServer, wait_for
from tests.server.plots.test_history import plot

pytestmark = pytest.mark.alone

TICK = ROW.fields["tick"][1] + 8
"""Place of the tick in a FRAME message."""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "message"),
        ("not json", "message"),
        ("[]", "message"),
        ('{"type": "dance"}', "type"),
        ('{"id": 5, "x": 1}', "type"),
        ('{"type": "target", "id": 5, "x": 0.1}', "target.y"),
        ('{"type": "target", "id": 5, "x": "a", "y": 0}', "target.x = a"),
        ('{"type": "target", "id": 5, "x": NaN, "y": 0}', "target.x = nan"),
        ('{"type": "target", "id": 5, "x": 99, "y": 0}', "target.x = 99"),
        ('{"type": "target", "id": 5, "x": 0, "y": 0, "z": 0}', "target.z"),
        ('{"type": "target", "id": -1, "x": 0, "y": 0}', "target.id = -1"),
        ('{"type": "presence", "n": 1.5}', "presence.n"),
        ('{"type": "ping", "t": NaN}', "ping.t = nan"),
        ('{"type": "ping", "t": 1, "round_trip": 1e308}', "ping.round_trip = 1e+308"),
        ('{"type": "plots", "channels": ["energy", "charm"]}', "charm"),
        ('{"type": "plots", "channels": ["../energy"]}', "plots.channels.0"),
        ('{"type": "plots", "channels": "energy"}', "plots.channels"),
        ('{"type": "plots", "channels": [], "since": NaN}', "plots.since = nan"),
        (json.dumps({"type": "plots", "channels": ["energy"] * (CHANNELS_MAX + 1)}), "plots.channels"),
        ("[" * 3000, "message"),
        ("x" * 5000, "4096"),
        (b"\x01\x02", "text"),
    ],
)
def test_a_malformed_message_is_refused_by_name_and_the_socket_goes_on(
    text: str | bytes, words: str, server: TestServer
) -> None:
    page = server.page().sign_in()
    with page.live() as live:
        live.socket.send(text)
        refused = live.wait("refused")
        assert words in refused["detail"], refused
        assert refused["id"] == (5 if isinstance(text, str) and '"id": 5' in text else 0)
        live.send(type="ping", t=4.25)
        assert live.wait("pong")["t"] == 4.25


def test_an_oversized_message_closes_only_its_own_socket(server: TestServer) -> None:
    page = server.page().sign_in()
    with page.live() as other:
        bad = page.connect("/ws/live")
        with pytest.raises(ConnectionClosed) as closed:
            bad.send("x" * (2 << 20))
            while True:
                bad.recv(timeout=60)
        assert closed.value.rcvd is None or closed.value.rcvd.code == 1009
        other.send(type="ping", t=1.0)
        assert other.wait("pong")


def test_history_comes_on_connect_and_every_tick_is_in_a_bin(server: TestServer) -> None:
    page = server.operator()
    wait_for(lambda: server.services.history.count > 2000, "two seconds of history")
    with page.live() as live:
        live.send(type="plots", channels=["energy", "p_ref.0"])
        wait_for(lambda: len(live.plots) > 30, "plots")
        plots = [plot(message) for message in live.plots]
        assert len(plots[0][2]) > 100, "the past comes first"
        t = np.concatenate([times for _, _, times, _, _ in plots])
        assert np.all(np.diff(t) > 0)
        assert np.median(np.diff(t)) < 0.05
        for _, channels, _, low, high in plots:
            assert [CHANNELS[channel].key for channel in channels] == ["energy", "p_ref.0"]
            assert not np.any(low > high)


def test_a_page_that_chose_no_channel_gets_none(server: TestServer) -> None:
    page = server.operator()
    with page.live() as live:
        wait_for(lambda: len(live.frames) > 20, "frames")
        assert not live.plots


def test_a_spike_of_one_tick_reaches_every_viewer(server: TestServer) -> None:
    """A row is put into the history as the link would; its neighbours are ordinary."""
    page = server.operator()
    history = server.services.history
    with page.live() as live:
        live.send(type="plots", channels=["p_meas.norm"])
        wait_for(lambda: len(live.plots) > 5, "plots")
        spike = history.newest.copy()
        spike["p_meas"] = (0.0, 7.0)
        history.add(spike)
        wait_for(lambda: any(plot(m)[4].max() == 7.0 for m in list(live.plots)), "the spike")


def test_a_slow_viewer_skips_frames_and_then_sees_the_newest(server: TestServer) -> None:
    page = server.operator()
    slow = page.connect("/ws/live", max_queue=1)
    slow.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    with page.live() as quick:
        wait_for(lambda: quick.frames, "frames")
        stuck = wait_for(lambda: _stuck(server), "the slow viewer to be stuck")
        at, seen = stuck.cursor, len(quick.frames)
        wait_for(lambda: len(quick.frames) > seen + 120, "the quick viewer to go on")
        assert stuck.cursor == at, "nothing more was prepared for the slow one"
        last = quick.frames[-1]["tick"]
        slow.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        ticks = []
        while not ticks or ticks[-1] < last:
            message = slow.recv(timeout=60)
            if isinstance(message, bytes) and message[0] == 1:
                ticks.append(int(np.frombuffer(message, "<i8", 1, TICK)[0]))
        assert np.diff(ticks).max() > 1500, "what was stale is skipped"
        slow.socket.shutdown(socket.SHUT_RDWR)
        slow.close()
        wait_for(lambda: len(server.services.pages.open) == 1, "the slow viewer to be forgotten")


def _stuck(server: TestServer) -> object:
    """The viewer that has not been sent anything for half a second."""
    before = {viewer: viewer.cursor for viewer in list(server.services.pages.open)}
    time.sleep(0.5)
    return next((viewer for viewer, cursor in before.items() if viewer.cursor == cursor), None)


def test_latecomers_read_the_log(server: TestServer) -> None:
    operator = server.operator()
    name = operator.get("/api/session").json()["name"]
    late = server.page().sign_in()
    with late.live() as live:
        log = [line["text"] for line in live.wait("hello")["log"]]
        assert f"{name}: clear" in log
        assert f"{name} operates" in log
        lease = {"held": True, "mine": False, "holder": name, "clutch": False, "lost": ""}
        assert live.wait("status")["lease"] == lease


def test_whatever_is_refused_is_in_the_log_with_who_and_why(server: TestServer) -> None:
    operator = server.operator()
    name = operator.get("/api/session").json()["name"]
    viewer = server.page().sign_in()
    other = viewer.get("/api/session").json()["name"]
    with viewer.live() as live:
        why = f"refused: only the operator may do this; {name} operates now"
        viewer.command("arm")
        live.wait("event", lambda m: m["text"] == f"{other}: arm {why}" and m["level"] == "warning")
        viewer.patch("/api/settings", json={"changes": {"K_P": [0.1, 0.1]}})
        live.wait("event", lambda m: m["text"] == f"{other}: change settings {why}")
        operator.patch("/api/settings", json={"changes": {"K_P": [9, 0.1]}})
        live.wait("event", lambda m: m["text"].startswith(f"{name}: change settings refused: K_P.0 = 9"))
        operator.post("/api/command", json={"request": "dance"})
        live.wait("event", lambda m: m["text"].startswith(f"{name}: dance refused: request = dance"))
        operator.command("follow", target=[0.1, 0.1])
        live.wait("event", lambda m: m["text"].startswith(f"{name}: follow refused") and m["level"] == "warning")
        server.page().post("/api/session", json={"token": "guess"})
        live.wait("event", lambda m: "sign in by token refused: wrong access token" in m["text"])
        for i in range(5):
            live.send(type="target", id=i, x=0.1, y=0.1, start=i == 0)
        live.wait("refused", lambda m: m["id"] == 4)
        live.send(type="target", id=9, x=0.1, y=0.1, start=True)
        live.wait("refused", lambda m: m["id"] == 9)
        lines = [m for m in live.texts if m["type"] == "event" and m["text"] == f"{other}: target {why}"]
        assert len(lines) == 2, "a drag is one command"


def test_the_clutch_is_the_holders_to_switch(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    assert viewer.patch("/api/lease", json={"clutch": True}).status_code == 403
    with viewer.live() as live:
        assert operator.patch("/api/lease", json={"clutch": True}).json()["clutch"] is True
        live.wait("status", lambda m: m["lease"]["clutch"])
        operator.patch("/api/lease", json={"clutch": False})


def test_a_closed_page_is_forgotten(server: TestServer) -> None:
    page = server.page().sign_in()
    with page.live():
        wait_for(lambda: len(server.services.pages.open) == 1, "the viewer")
    wait_for(lambda: not server.services.pages.open, "the viewer to be dropped")


def test_in_a_crowd_viewers_take_turns_and_the_operator_gets_every_beat(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    with contextlib.ExitStack() as pages:
        operating = pages.enter_context(operator.live())
        operating.operate()
        watching = [pages.enter_context(viewer.live()) for _ in range(VIEWERS_ALL_BEATS_MAX)]
        wait_for(lambda: all(page.frames for page in watching), "frames for all")
        begin = [len(page.frames) for page in (operating, *watching)]
        wait_for(lambda: len(operating.frames) > begin[0] + 200, "frames of the operator")
        got = [len(page.frames) - before for page, before in zip((operating, *watching), begin, strict=True)]
    assert 0.4 * got[0] < np.median(got[1:]) < 0.7 * got[0]


def test_a_status_tells_whether_it_was_read_before_or_after_an_answer(server: TestServer) -> None:
    page = server.page().sign_in()
    with page.live() as live:
        live.wait("status")
        for method, mine in (("POST", True), ("DELETE", False)) * 3:
            answered = float(page.request(method, "/api/lease").headers["tendril-time"])
            live.wait("status", lambda said, at=answered: said["read_at"] > at)
            told = [said for said in live.texts if said["type"] == "status"]
            assert {said["lease"]["mine"] for said in told if said["read_at"] > answered} == {mine}
            live.texts.clear()
