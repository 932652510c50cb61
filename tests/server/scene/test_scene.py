"""ViewSessions: what one page's 3D view has for itself, and what it may not touch."""

from typing import Any

import msgpack
import numpy as np
import zstandard

from recordings.read.playback import PlaybackRows
from server.scene.lines import STYLES, dashes
from server.scene.messages import PlaybackBody
from server.scene.playback import Player
from tests.server.listed import listed
from tests.server.live_server import Page, TestServer, wait_for
from tests.server.scene.test_viser import CAMERA_POSE, VERSION, clients, say

SEAT, OTHER = "seat0000one", "seat0000two"


class Eye:
    """A client of viser on a seat, and what it was told and no one asked for yet."""

    def __init__(self, page: Page, seat: str) -> None:
        self.socket = page.connect(f"/viser/seat/{seat}", subprotocols=[VERSION], close_timeout=1)
        self._told: list[dict[str, Any]] = []
        say(self.socket, CAMERA_POSE)

    def hear(self, kind: str, name: str = "", own: bool = False) -> dict[str, Any]:
        """The next message of this type, about this scene node if named; `own`: about this client's variant of it."""
        while True:
            while self._told:
                message = self._told.pop(0)
                mine = not own or message.get("owner", "") != ""
                if message["type"] == kind and name in ("", message.get("name")) and mine:
                    return message
            packed = self.socket.recv(timeout=60)
            size = int.from_bytes(packed[8:16], "little")
            self._told = msgpack.unpackb(zstandard.ZstdDecompressor().decompress(packed[16 : 16 + size]))["messages"]


def test_a_seat_shows_its_own_path_and_camera_and_belongs_to_one_session(server: TestServer) -> None:
    mine, theirs = server.page().sign_in(), server.page().sign_in()
    eye = Eye(mine, SEAT)
    wait_for(lambda: clients(server) == 1, "the page in viser")
    path = {"lines": [[[0.1, 0.0], [0.2, 0.0], [0.2, 0.1]], [[0.0, 0.1], [0.0, 0.2]]]}
    assert mine.put(f"/api/scene/{SEAT}/path/reference", json=path).status_code == 204
    eye.hear("LineSegmentsMessage", "/path/reference")
    assert mine.put(f"/api/scene/{SEAT}/look", json={"scheme": "light", "view": "oblique"}).status_code == 204
    at = eye.hear("SetCameraPositionMessage")["position"]
    assert at[1] < 0 < at[2]
    assert theirs.put(f"/api/scene/{SEAT}/look", json={"scheme": "dark"}).status_code == 403
    assert mine.put(f"/api/scene/{SEAT}/path/trail", json=path).status_code == 422
    eye.socket.close()


def test_a_recording_plays_in_one_view_and_the_others_stay_live(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    assert operator.post("/api/recordings", json={}).status_code == 200
    wait_for(lambda: listed(operator)[0]["rows"] >= 0, "a recording")
    current = server.services.recorder.state().id
    refused = viewer.put(f"/api/scene/{SEAT}/playback", json={"recording": current})
    assert (refused.status_code, "stop it first" in refused.text) == (409, True)
    wait_for(lambda: server.services.recorder.state().rows > 300, "some rows")
    assert operator.delete("/api/recordings/current").status_code == 200
    playing, live = Eye(viewer, SEAT), Eye(operator, OTHER)
    wait_for(lambda: clients(server) == 2, "both in viser")
    state = viewer.put(f"/api/scene/{SEAT}/playback", json={"recording": current, "playing": False, "at": 0.1}).json()
    assert (state["at"], state["playing"]) == (0.1, False)
    assert state["duration"] > 0.2
    assert not playing.hear("SetSceneNodeVisibilityMessage", "/live", own=True)["visible"]
    playing.hear("SetPositionMessage", "/played/rod10")
    live.hear("SetPositionMessage", "/live/rod10")
    seats = {id: seat for id, seat in server.services.scene._sessions._sessions.items() if seat.player is not None}
    assert list(seats) == [SEAT]
    assert viewer.delete(f"/api/scene/{SEAT}/playback").status_code == 204
    assert viewer.put(f"/api/scene/{SEAT}/playback", json={"recording": "none"}).status_code == 404
    playing.socket.close()
    live.socket.close()


def test_a_player_runs_at_its_rate_on_the_servers_clock_and_stands_at_the_end() -> None:
    clock = [100.0]
    tip = np.column_stack([np.linspace(0.0, 0.5, 51), np.zeros(51)])
    playback = PlaybackRows(np.linspace(0.0, 1.0, 51), {"p_meas": tip}, None)  # type: ignore[arg-type]
    player = Player("one", playback, lambda: clock[0])
    player.control(PlaybackBody(recording="one", at=0.2, rate=2.0))
    clock[0] += 0.2
    assert abs(player.at - 0.6) < 1e-9
    assert abs(playback.row(player.at)["p_meas"][0] - 0.3) < 1e-9
    assert len(playback.trail(player.at, 0.1)) == 5
    clock[0] += 5.0
    assert (player.at, player.state().playing) == (1.0, False)


def test_dashes_lie_on_the_line_and_cover_their_share_of_it() -> None:
    square = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]])
    ends = dashes(square, STYLES["reference"])
    lengths = np.linalg.norm(np.diff(ends, axis=1)[:, 0], axis=1)
    assert abs(lengths.sum() / 0.2 - 7 / 11) < 0.05
    assert np.all((np.abs(ends[..., 1]) < 1e-12) | (np.abs(ends[..., 0] - 0.1) < 1e-12))
    assert dashes(square[:1], STYLES["ghost"]).shape == (0, 2, 2)
