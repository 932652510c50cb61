"""The 3D view through the proxy, spoken to as viser's own client does."""

import io
from typing import Any

import msgpack
import pytest
import viser
import zstandard
from websockets.sync.client import ClientConnection

from controller.schema.modes import Mode
from server.scene.drag import CAMERA, END, START, UPDATE
from server.scene.scene import GIZMO
from tests.server.live_server import Page, TestServer, wait_for

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]

VERSION = f"viser-v{viser.__version__}"
CAMERA_POSE = {
    "type": CAMERA,
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, 1.0],
    "fov": 0.5,
    "near": 0.01,
    "far": 10.0,
    "image_height": 100,
    "image_width": 100,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 1.0, 0.0],
}


def enter(page: Page) -> ClientConnection:
    """Connect as viser's page does; it counts as a client after its first camera message."""
    socket = page.connect("/viser", subprotocols=[VERSION], close_timeout=1)
    assert socket.subprotocol == VERSION
    say(socket, CAMERA_POSE)
    return socket


def say(socket: ClientConnection, message: dict[str, Any]) -> None:
    socket.send(bytes(msgpack.packb(message)))


def gizmo(kind: str, *position: float) -> dict[str, Any]:
    message: dict[str, Any] = {"type": kind, "name": GIZMO, "owner": ""}
    if position:
        message |= {"position": [*position, 0.0], "wxyz": [1.0, 0.0, 0.0, 0.0]}
    return message


def drag(socket: ClientConnection, *position: float) -> None:
    say(socket, gizmo(START))
    say(socket, gizmo(UPDATE, *position))
    say(socket, gizmo(END))


def clients(server: TestServer) -> int:
    return len(server.services.scene._viser.get_clients())


def test_the_operators_gizmo_moves_the_target_and_a_viewers_does_not(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    with operator.live() as live:
        live.operate()
        operator.command("arm")
        live.wait_mode(Mode.HOLD)
        theirs, ours = enter(viewer), enter(operator)
        wait_for(lambda: clients(server) == 2, "both in viser")
        before = live.frames[-1]["request_n"]
        drag(theirs, 0.15, 0.12)
        theirs.send(b"\xc1garbage")
        say(theirs, {"type": "ShareUrlRequest"})
        say(theirs, {**CAMERA_POSE, "fov": 0.7})
        poses = server.services.scene._viser.get_clients
        wait_for(lambda: any(abs(c.camera.fov - 0.7) < 1e-6 for c in poses().values()), "the last camera message")
        seen = live.frames[-1]
        assert (seen["mode"], seen["request_n"]) == (Mode.HOLD, before), "the viewer's drag went nowhere"
        drag(ours, 0.15, 0.12)
        live.wait_mode(Mode.FOLLOW)
        wait_for(lambda: abs(live.frames[-1]["target"] - (0.15, 0.12)).max() < 1e-9, "the target")
        wait_for(lambda: abs(live.frames[-1]["p_meas"] - (0.15, 0.12)).max() < 0.003, "the tip")
        drag(theirs, 0.2, 0.0)
        drag(ours, 0.16, 0.12)
        wait_for(lambda: abs(live.frames[-1]["target"] - (0.16, 0.12)).max() < 1e-9, "the next target")
        theirs.close()
        ours.close()
        wait_for(lambda: clients(server) == 0, "viser to forget both")


def test_speaking_to_viser_behind_the_proxys_back_moves_nothing(server: TestServer) -> None:
    """Anything on this machine can reach viser's own port, even a foreign page in the operator's browser."""
    from websockets.sync.client import connect

    operator = server.operator()
    with operator.live() as live:
        live.operate()
        operator.command("arm")
        live.wait_mode(Mode.HOLD)
        port = server.services.scene.port
        with connect(f"ws://127.0.0.1:{port}", subprotocols=[VERSION], proxy=None, max_size=None) as socket:
            say(socket, CAMERA_POSE)
            wait_for(lambda: clients(server) == 1, "the intruder")
            before = live.frames[-1]["tick"]
            drag(socket, 0.15, 0.12)
            say(socket, {"type": "ShareUrlRequest"})
            wait_for(lambda: live.frames[-1]["tick"] > before + 500, "half a second")
            assert live.frames[-1]["mode"] == Mode.HOLD
        assert server.services.scene._viser._share_tunnel is None


def test_a_viewers_misplaced_gizmo_is_put_back(server: TestServer) -> None:
    server.operator()
    viewer = server.page().sign_in()
    socket = enter(viewer)
    wait_for(lambda: clients(server) == 1, "the viewer")
    moved: list[Any] = []
    wait_for(lambda: _mentions(socket.recv(timeout=60), moved), "the first pose of the gizmo")
    moved.clear()
    drag(socket, 0.3, 0.3)
    wait_for(lambda: _mentions(socket.recv(timeout=60), moved), "the pose again")
    assert moved[-1]["position"][:2] != [0.3, 0.3]
    socket.close()


def _mentions(packed: Any, found: list[Any]) -> bool:
    """Whether this downward message sets the gizmo's position (sizes, then zstd-packed msgpack)."""
    size = int.from_bytes(packed[8:16], "little")
    inner = msgpack.unpackb(zstandard.ZstdDecompressor().decompress(packed[16 : 16 + size]))
    found += [m for m in inner["messages"] if m["type"] == "SetPositionMessage" and m["name"] == GIZMO]
    return bool(found)


def test_visers_page_is_served_with_its_panel_hidden(server: TestServer) -> None:
    page = server.page().sign_in()
    shell = page.get("/viser/")
    assert shell.status_code == 200
    assert "data-floating-window" in shell.text.split("</head>")[0]
    again = page.get("/viser/", headers={"if-none-match": shell.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    top = page.get("/viser/seat/seat0000top/?view=top&scheme=light")
    assert top.status_code == 307
    assert "initialCameraUp=0.0000,1.0000,0.0000" in top.headers["location"]
    assert page.get("/viser/nothing.js").status_code == 404
    assert page.get("/viser/..%2f..%2fpyproject.toml").status_code == 404


def test_a_client_of_another_version_is_turned_away_without_harm(server: TestServer) -> None:
    page = server.page().sign_in()
    socket = page.connect("/viser", subprotocols=["viser-v0.0.1"])
    with pytest.raises(Exception, match=r".*"):
        while True:
            socket.recv(timeout=60)
    assert page.get("/viser/").status_code == 200


def test_reruns_viewer_is_served_whole(server: TestServer) -> None:
    page = server.page().sign_in()
    wait_for(lambda: page.get("/rerun/").status_code != 503 or server.services.review.problem, "the viewer")
    assert server.services.review.problem == ""
    assert "re_viewer.js" in page.get("/rerun/").text
    wasm = page.get("/rerun/re_viewer_bg.wasm")
    assert wasm.headers["content-type"] == "application/wasm"
    assert wasm.headers["content-encoding"] == "gzip"
    assert io.BytesIO(wasm.content).read(4) == b"\0asm"
    assert int(wasm.headers["rerun-final-length"]) == len(wasm.content)
    assert page.get("/rerun/secrets.json").status_code == 404
