"""Who gets in, from where, and what only the operator may do."""

import itertools
import logging
import re
import time
from collections.abc import Iterator

import pytest
from fastapi.routing import APIRoute
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from websockets.exceptions import InvalidStatus

from server.app.app import openapi_schema
from server.http.rates import ANONYMOUS, SIGN_IN, WRONG_TOKEN
from tests.server.live_server import TOKEN, VIEWER_TOKEN, TestServer

OPEN = {("GET", "/"), ("HEAD", "/"), ("POST", "/api/session"), ("GET", "/healthz")}
"""What answers without a session, the last one to this machine alone; assets are mounted, not routed."""
OPERATORS = [
    ("POST", "/api/command", {"request": "arm"}),
    ("POST", "/api/command", {"request": "hold"}),
    ("POST", "/api/command", {"request": "follow", "target": [0.1, 0.1]}),
    ("POST", "/api/command", {"request": "rest"}),
    ("POST", "/api/command", {"request": "clear"}),
    ("PATCH", "/api/settings", {"changes": {"K_P": [0.1, 0.1]}}),
    ("PATCH", "/api/lease", {"clutch": True}),
    ("POST", "/api/recordings", {"name": "x"}),
    ("DELETE", "/api/recordings/current", None),
    *[("POST", f"/api/run{verb}", {"reference": "vu"}) for verb in ("", "/again", "/pause", "/resume", "/stop")],
]


def walk(routes: list[BaseRoute]) -> Iterator[tuple[str, str]]:
    """Method and path of everything that is routed."""
    for route in routes:
        if isinstance(route, WebSocketRoute):
            yield "WEBSOCKET", route.path
        elif isinstance(route, Route | APIRoute):
            yield from ((method, route.path) for method in route.methods or ())
        elif not isinstance(route, Mount) and (inner := getattr(route, "original_router", None)):
            yield from walk(inner.routes)


def test_nothing_answers_without_a_session(server: TestServer, caplog: pytest.LogCaptureFixture) -> None:
    page = server.page()
    found = set(walk(server.app.routes))
    assert {("PATCH", "/api/settings"), ("GET", "/api/recordings/{id}.rrd"), ("WEBSOCKET", "/ws/live")} <= found
    assert {("GET", "/viser/{path:path}"), ("WEBSOCKET", "/viser"), ("GET", "/rerun/{name}")} <= found
    assert len(found) >= 20
    for method, pattern in found - OPEN:
        path = re.sub(r"\{.*?\}", "x", pattern)
        if method == "WEBSOCKET":
            with pytest.raises(InvalidStatus) as refused:
                page.connect(path)
            assert refused.value.response.status_code == 401, path
        else:
            assert page.request(method, path).status_code == 401, (method, path)
    assert page.get("/api/openapi.json").status_code == 401
    assert page.get("/no/such/path").status_code == 401
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []


def test_forged_cookies_are_no_session(server: TestServer) -> None:
    page = server.page()
    for value in ("x", "WyJpZCIsIm5hbWUiXQ.aaaa.bbbb", ""):
        page.cookies.set(server.services.sessions.cookie, value)
        assert page.get("/api/session").status_code == 401


def test_wrong_tokens_get_401_then_429_and_a_right_one_from_there_lets_in_by_every_door(server: TestServer) -> None:
    page, now = server.page(), time.monotonic()
    for bucket in vars(server.services.rates).values():
        bucket._now = lambda: now  # no token comes back, however slow the machine is
    many = int(max(ANONYMOUS.burst, SIGN_IN.burst)) + 10
    codes = [page.post("/api/session", json={"token": "wrong"}).status_code for _ in range(many)]
    assert codes == [401] * int(WRONG_TOKEN.burst) + [429] * (many - int(WRONG_TOKEN.burst))
    stopped = page.post("/api/session", json={"token": "wrong"})
    assert (stopped.headers["retry-after"], page.cookies) == ("12", {})
    assert {page.get("/", params={"token": "wrong"}).status_code for _ in range(10)} <= {429, 503}
    assert page.get("/metrics", headers={"authorization": "Bearer wrong"}).status_code == 429
    while page.get("/no/such/path").status_code == 401:
        pass  # until strangers from here may ask for nothing more
    assert page.get("/metrics", headers={"authorization": f"Bearer {VIEWER_TOKEN}"}).status_code == 200
    for _ in range(int(SIGN_IN.burst) + 10):
        page.cookies.clear()
        assert page.post("/api/session", json={"token": VIEWER_TOKEN}).status_code == 200
    last = server.page()
    assert last.get("/", params={"token": VIEWER_TOKEN}).status_code == 303
    assert last.command("e_stop").status_code == 200
    assert server.page().sign_in().operate().get("/api/settings").status_code == 200
    said = [line.text for line in server.services.events.recent if "signed in with the viewer's" in line.text]
    assert len(said) == SIGN_IN.burst, "no more lines than that"


def test_token_in_the_address_becomes_a_cookie_and_leaves_the_address(server: TestServer) -> None:
    page = server.page()
    answer = page.get("/", params={"token": TOKEN})
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=lax" in cookie
    assert answer.headers["referrer-policy"] == "no-referrer"
    name = page.get("/api/session").json()["name"]
    page.get("/", params={"token": TOKEN})
    assert page.get("/api/session").json()["name"] == name, "the same browser stays who it is"
    assert server.page().get("/", params={"token": "wrong"}).status_code in (401, 503)


def test_other_origins_are_refused_even_with_the_cookie(server: TestServer) -> None:
    page = server.page().sign_in()
    for origin in ("http://evil.example", "null", "http://["):
        assert page.post("/api/lease", headers={"origin": origin}).status_code == 403
        for path in ("/ws/live", "/viser"):
            with pytest.raises(InvalidStatus) as refused:
                page.connect(path, headers={"origin": origin})
            assert refused.value.response.status_code == 403
    assert page.post("/api/lease", headers={"origin": server.url}).status_code == 200
    page.connect("/ws/live", headers={"origin": server.url}).close()


def test_a_malformed_origin_is_refused_like_any_other_and_counted(
    server: TestServer, caplog: pytest.LogCaptureFixture
) -> None:
    stranger, odd, now = server.page(), {"origin": "http://["}, time.monotonic()
    server.services.rates._stranger._now = lambda: now  # no token comes back, however slow the machine is
    codes = [stranger.post("/api/lease", headers=odd).status_code for _ in range(400)]
    assert set(codes) == {403, 429} and codes[0] == 403
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []


def test_every_answer_carries_the_security_headers(server: TestServer) -> None:
    page = server.page().sign_in()
    for path in ("/", "/api/health", "/viser/", "/rerun/", "/nothing"):
        headers = page.get(path).headers
        assert "frame-ancestors 'self'" in headers["content-security-policy"], path
        assert headers["x-content-type-options"] == "nosniff"
        inline = "script-src 'self' 'unsafe-inline'" in headers["content-security-policy"]
        assert inline == path.startswith(("/viser", "/rerun")), path


def test_a_viewer_may_stop_but_nothing_else(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    for method, path, body in OPERATORS:
        answer = viewer.request(method, path, json=body)
        assert answer.status_code == 403, (method, path)
        assert operator.get("/api/session").json()["name"] in answer.json()["detail"], "it says who operates"
    with viewer.live() as live:
        live.operate()
        live.send(type="target", id=3, x=0.1, y=0.1, start=True)
        assert "operator" in live.wait("refused", lambda m: m["id"] == 3)["detail"]
    assert viewer.command("e_stop").status_code == 200
    assert server.services.operator.settings.K_P != (0.1, 0.1)


def test_long_bodies_are_not_read(server: TestServer) -> None:
    page = server.page().sign_in().operate()
    assert page.post("/api/recordings", content=b"x" * (1 << 21)).status_code == 413


def test_a_body_without_a_length_is_not_read_even_before_signing_in(server: TestServer) -> None:
    endless = itertools.repeat(b"x" * 1000, 100)
    assert server.page().post("/api/session", content=endless).status_code == 411


def test_odd_paths_find_nothing(server: TestServer) -> None:
    page = server.page().sign_in()
    for path in ("/viser/%00", "/viser/..%2f..%2f..%2fetc%2fpasswd", "/assets/..%2fsettings.py", "/rerun/..%2ftool.py"):
        assert page.get(path).status_code == 404, path


def test_the_description_holds_the_socket_messages() -> None:
    schema = openapi_schema()
    kinds = schema["components"]["schemas"]
    assert {"Hello", "Status", "Reply", "Refused", "Pong", "LogEntry", "Target", "Presence", "Ping"} <= set(kinds)
    assert "type" in kinds["Hello"]["required"], "the page can tell messages apart by it"
    assert kinds["Mode"]["x-enum-varnames"][6] == "E_STOP"
    spoken = schema["webhooks"]["live"]["post"]
    assert len(spoken["requestBody"]["content"]["application/json"]["schema"]["oneOf"]) == 6
