"""Every route of the application, and whom it obeys: a new one that changes something must be said here."""

import re
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from server.access.roles import READING
from tests.server.access.test_doors import walk
from tests.server.live_server import VIEWER_TOKEN, TestServer

ANYONE, OPERATOR, LEASE = "anyone", "operator", "lease"
NEEDS = {
    ("POST", "/api/session"): ANYONE,
    ("POST", "/api/lease"): OPERATOR,
    ("DELETE", "/api/lease"): OPERATOR,
    ("PATCH", "/api/lease"): LEASE,
    ("POST", "/api/lease/request"): ANYONE,
    ("DELETE", "/api/lease/request"): ANYONE,
    ("POST", "/api/lease/refuse"): LEASE,
    ("POST", "/api/lease/hand-over"): LEASE,
    ("POST", "/api/lease/take-over"): OPERATOR,
    ("POST", "/api/command"): ANYONE,  # E-STOP; the rest is below
    ("PATCH", "/api/settings"): LEASE,
    ("PUT", "/api/controller"): LEASE,
    ("PUT", "/api/alarms"): ANYONE,
    ("DELETE", "/api/alarms"): ANYONE,
    ("POST", "/api/drawings/plan"): ANYONE,
    ("POST", "/api/drawings/text"): ANYONE,
    ("POST", "/api/drawings/import"): ANYONE,
    ("POST", "/api/drawings/import/proposal"): ANYONE,
    ("POST", "/api/preview"): ANYONE,
    ("POST", "/api/preview/parts"): ANYONE,
    ("PUT", "/api/drawings/{name}"): LEASE,
    ("DELETE", "/api/drawings/{name}"): LEASE,
    ("POST", "/api/run"): LEASE,
    ("POST", "/api/run/again"): LEASE,
    ("POST", "/api/run/learn"): LEASE,
    ("DELETE", "/api/learned/{key}"): LEASE,
    ("POST", "/api/run/pause"): LEASE,
    ("POST", "/api/run/resume"): LEASE,
    ("POST", "/api/run/stop"): LEASE,
    ("PUT", "/api/macros/{name}"): OPERATOR,
    ("DELETE", "/api/macros/{name}"): OPERATOR,
    ("POST", "/api/macros/{name}/run"): LEASE,
    ("POST", "/api/macros/stop"): LEASE,
    ("POST", "/api/recordings"): LEASE,
    ("DELETE", "/api/recordings/current"): LEASE,
    ("POST", "/api/recordings/current/bookmarks"): LEASE,
    ("PATCH", "/api/recordings/{id}/bookmarks/{n}"): OPERATOR,
    ("DELETE", "/api/recordings/{id}/bookmarks/{n}"): OPERATOR,
    ("PATCH", "/api/recordings/{id}"): OPERATOR,
    ("DELETE", "/api/recordings/{id}"): OPERATOR,
    ("DELETE", "/api/recordings/deleted"): OPERATOR,
    ("POST", "/api/recordings/{id}/restore"): OPERATOR,
    ("POST", "/api/recordings/{id}/exports"): ANYONE,
    ("POST", "/api/recordings/import"): LEASE,
    ("PUT", "/api/gains/{name}"): LEASE,
    ("DELETE", "/api/gains/{name}"): LEASE,
    ("PUT", "/api/rig/actuator"): LEASE,
    ("PUT", "/api/rig/plant"): LEASE,
    ("PUT", "/api/rig/observer-kappa"): LEASE,
    ("POST", "/api/first-mode/measure"): LEASE,
    ("POST", "/api/first-mode/stop"): LEASE,
    ("PUT", "/api/rig-file"): LEASE,
    ("POST", "/api/commissioning/{step}/start"): LEASE,
    ("POST", "/api/commissioning/{step}/stop"): LEASE,
    ("POST", "/api/commissioning/{step}/accept"): LEASE,
    ("POST", "/api/commissioning/{step}/back"): LEASE,
    ("PUT", "/api/commissioning/jog"): LEASE,
    ("PUT", "/api/commissioning/jog/confirm"): LEASE,
    ("PUT", "/api/commissioning/frame/capture"): LEASE,
    ("PUT", "/api/layouts/{name}"): ANYONE,
    ("DELETE", "/api/layouts/{name}"): ANYONE,
    ("PUT", "/api/twin/faults"): LEASE,
    ("PUT", "/api/twin/time"): LEASE,
    ("PUT", "/api/scene/{seat}/look"): ANYONE,
    ("PUT", "/api/scene/{seat}/path/{role}"): ANYONE,
    ("PUT", "/api/scene/{seat}/playback"): ANYONE,
    ("DELETE", "/api/scene/{seat}/playback"): ANYONE,
    ("DELETE", "/api/sessions/{role}"): OPERATOR,
    ("DELETE", "/api/session"): ANYONE,  # last, as it ends what is asked with
}


def filled(pattern: str) -> str:
    return re.sub(r"\{.*?\}", "nothing", pattern)


def test_every_route_that_changes_something_says_whom_it_obeys(server: TestServer) -> None:
    found = {(method, path) for method, path in walk(server.app.routes) if method not in (*READING, "WEBSOCKET")}
    assert found == set(NEEDS)
    viewer, idle, operator = server.page().sign_in(VIEWER_TOKEN), server.page().sign_in(), server.operator()
    for (method, path), need in NEEDS.items():
        refused = viewer.request(method, filled(path)).status_code == 403
        assert refused == (need != ANYONE), (method, path, "with the viewer's token")
        refused = idle.request(method, filled(path)).status_code == 403
        assert refused == (need == LEASE), (method, path, "with the operator's token, without the lease")
    assert operator.patch("/api/lease", json={"clutch": False}).status_code == 200, "they took nothing away"


@pytest.mark.parametrize("request_", ["arm", "hold", "follow", "rest", "clear"])
def test_a_viewers_only_command_is_the_e_stop(request_: str, server: TestServer) -> None:
    viewer = server.page().sign_in(VIEWER_TOKEN)
    server.operator()
    assert viewer.command(request_, target=[0.1, 0.1]).status_code == 403
    assert viewer.command("e_stop").status_code == 200


def test_everything_that_acts_refuses_another_origin(server: TestServer) -> None:
    page = server.page().sign_in()
    for method, pattern in set(walk(server.app.routes)):
        path = filled(pattern)
        if method == "WEBSOCKET":
            with pytest.raises(InvalidStatus) as refused:
                page.connect(path, headers={"origin": "http://evil.example"})
            assert refused.value.response.status_code == 403, path
        elif method not in READING:
            answer = page.request(method, path, headers={"origin": "http://evil.example"})
            assert (answer.status_code, "another origin" in answer.text) == (403, True), (method, path)


def test_a_viewers_target_is_refused_though_the_lease_is_free(server: TestServer) -> None:
    with server.page().sign_in(VIEWER_TOKEN).live() as live:
        hello: dict[str, Any] = live.wait("hello")
        assert hello["session"]["role"] == "viewer"
        live.operate()
        live.send(type="target", id=3, x=0.1, y=0.1, start=True)
        assert "operator" in live.wait("refused", lambda m: m["id"] == 3)["detail"]


def test_only_our_own_names_are_answered_on_loopback(server: TestServer) -> None:
    page = server.page().sign_in()
    port = server.url.rpartition(":")[2]
    for host in (f"localhost:{port}", f"127.0.0.1:{port}", f"[::1]:{port}", f"LOCALHOST:{port}"):
        assert page.get("/api/session", headers={"host": host}).status_code == 200, host
    for host in (f"evil.example:{port}", "localhost", "127.0.0.1:1", f"localhost.evil.example:{port}", ""):
        assert page.get("/", headers={"host": host}).status_code == 421, host


def test_the_page_asks_a_browser_for_nothing_but_gamepads(server: TestServer) -> None:
    headers = server.page().get("/").headers
    assert "gamepad=(self)" in headers["permissions-policy"]
    assert "camera=()" in headers["permissions-policy"]
    policy = dict(part.split(" ", 1) for part in headers["content-security-policy"].split("; "))
    assert (policy["script-src"], policy["worker-src"], policy["font-src"]) == ("'self'",) * 3
    assert "wss:" not in headers["content-security-policy"]
    assert "strict-transport-security" not in headers
