"""The E-STOP's own ways: by the live socket and by HTTP, from anyone, whatever else waits."""

import socket

import pytest

from controller.schema.modes import Mode
from tests.server.live_server import VIEWER_TOKEN, Page, TestServer, wait_for


def test_anyone_stops_by_the_socket_and_is_answered_with_the_number(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    assert operator.command("arm").status_code == 200
    with viewer.live() as live:
        live.send(type="e_stop", n=7)
        answer = live.wait("reply")
        assert (answer["n"], answer["id"], answer["reply"]["accepted"]) == (7, 0, True)
        assert answer["reply"]["mode"] == Mode.E_STOP
        live.wait_mode(Mode.E_STOP)
        live.wait("event", lambda m: m["text"].endswith("e-stop"))


def test_a_viewers_stop_is_named_as_the_viewers_in_status_and_log(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    assert operator.command("arm").status_code == 200
    name = f"{viewer.get('/api/session').json()['name']} (viewer)"
    with operator.live() as live:
        assert live.wait("status")["stopped_by"] == ""
        assert viewer.command("e_stop").status_code == 200
        live.wait("status", lambda m: m["stopped_by"] == name)
        live.wait("event", lambda m: m["text"] == f"rig: E-STOP (by {name})")
        assert operator.command("e_stop").status_code == 200  # the first who pressed stays
        assert operator.command("clear").status_code == 200
        wait_for(lambda: [m for m in live.texts if m["type"] == "status"][-1]["stopped_by"] == "", "its end")


def test_a_stop_passes_on_a_socket_whose_messages_are_dropped(server: TestServer) -> None:
    operator = server.operator()
    assert operator.command("arm").status_code == 200
    with operator.live() as live:
        while server.services.rates.message(_id_of(server)).name == "HEARD":
            pass
        live.send(type="e_stop", n=1)
        assert live.wait("reply")["n"] == 1
        live.wait_mode(Mode.E_STOP)


@pytest.mark.parametrize("text", ['{"type": "e_stop"}', '{"type": "e_stop", "n": -1}', '{"type": "e_stop", "n": "x"}'])
def test_a_malformed_stop_is_refused_by_name(text: str, server: TestServer) -> None:
    with server.page().sign_in().live() as live:
        live.socket.send(text)
        assert "e_stop.n" in live.wait("refused")["detail"]


BODY = b'{"request": "e_stop"}'
JSON = "content-type: application/json"


def test_by_http_behind_other_requests_it_acts_once_and_is_answered_in_its_turn(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, stopper = server.operator(), server.services.operator.stopper
    assert page.command("arm").status_code == 200
    pressed: list[int] = []
    really = stopper.stop
    monkeypatch.setattr(stopper, "stop", lambda who: pressed.append(1) or really(who))
    with socket.create_connection((page.base_url.host, page.base_url.port)) as link:
        link.sendall(raw(page, b'{"request": "hold"}', JSON) * 20 + raw(page, BODY, JSON))
        answers = b""
        while answers.count(b"HTTP/1.1 ") < 21 or not answers.endswith(b"}"):
            answers += link.recv(1 << 16)
    last = answers.split(b"HTTP/1.1 ")[-1]
    assert last.startswith(b"200") and b'"mode":6' in last
    assert len(pressed) == 1
    assert page.command("clear").status_code == 200


@pytest.mark.parametrize(
    ("headers", "body", "status"),
    [
        ([JSON], BODY, 200),
        (["content-type: Application/JSON; charset=utf-8"], BODY, 200),
        (["content-type: text/plain"], BODY, 422),
        ([JSON, "origin: http://evil.example"], BODY, 403),
        ([JSON, "origin: http://evil.example", "origin: http://evil.example"], BODY, 400),
        ([JSON, "host: evil.example"], BODY, 400),
        ([JSON, "cookie:"], BODY, 400),
        ([JSON], b'{"request": "e_stop", "more": 1}', 422),
        ([JSON], b'[{"request": "e_stop"}]', 422),
        ([JSON], b'{"request": "e_stop"', 422),
    ],
)
def test_what_the_gate_or_the_route_refuses_stops_nothing(
    headers: list[str], body: bytes, status: int, server: TestServer
) -> None:
    page = server.operator()
    assert page.command("arm").status_code == 200
    said = answer(page, raw(page, body, *headers))
    assert said.startswith(b"HTTP/1.1 %d" % status), said
    assert (page.command("hold").status_code == 200) == (status != 200)


def test_who_is_not_signed_in_stops_nothing_by_http(server: TestServer) -> None:
    page, stranger = server.operator(), server.page()
    assert page.command("arm").status_code == 200
    assert answer(stranger, raw(stranger, BODY, JSON)).startswith(b"HTTP/1.1 401")
    assert page.command("hold").status_code == 200


def raw(page: Page, body: bytes, *headers: str) -> bytes:
    """A POST to /api/command with these headers, too."""
    cookies = "; ".join(f"{name}={value}" for name, value in page.cookies.items())
    own = [f"cookie: {cookies}"] if cookies else []
    lines = [f"POST /api/command HTTP/1.1\r\nhost: {page.base_url.netloc.decode()}", *own, *headers]
    return "\r\n".join([*lines, f"content-length: {len(body)}", "", ""]).encode() + body


def answer(page: Page, request: bytes) -> bytes:
    """What begins to come back."""
    with socket.create_connection((page.base_url.host, page.base_url.port)) as link:
        link.sendall(request)
        return link.recv(1 << 12)


def _id_of(server: TestServer) -> str:
    holder = server.services.lease.holder
    assert holder is not None
    return holder.id
