"""Connections that send too much, too slowly, or no request at all: ended, while others are served."""

import asyncio
import contextlib
import gc
import logging
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import Mock

import pytest
import uvicorn
from uvicorn.server import ServerState

from server.http import connections
from server.http.connections import CHUNK_BYTES, HEAD_MAX, OPEN, Connection, ConnectionCount, Doorstep, Flow
from tests.server.live_server import TestServer, wait_for

pytestmark = pytest.mark.keyed()


@contextmanager
def raw(server: TestServer) -> Iterator[socket.socket]:
    """A bare connection to the server."""
    host, port = server.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=120) as found:
        yield found


def answer(connection: socket.socket) -> bytes:
    """All that comes until the server ends the connection."""
    found = b""
    try:
        while piece := connection.recv(65536):
            found += piece
    except ConnectionResetError:
        pass
    return found


@pytest.mark.parametrize(
    "begun",
    [
        b"",
        b"GET /api/health HTTP/1.1\r\nhost: x\r\n",
        b"POST /api/session HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\ncontent-length: 50\r\n\r\n{",
    ],
    ids=["nothing", "half a head", "half a body"],
)
def test_a_request_that_does_not_come_to_its_end_is_given_up(
    begun: bytes, server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Connection, "seconds", 0.5)
    with raw(server) as slow:
        slow.sendall(begun)
        assert b" 200 " not in answer(slow).split(b"\r\n")[0]
    assert server.page().sign_in().get("/api/session").status_code == 200


def test_dripping_bytes_do_not_buy_time(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Connection, "seconds", 1.0)
    with raw(server) as slow:
        slow.settimeout(0.1)
        slow.sendall(b"GET /api/health HTTP/1.1\r\nhost: x\r\nx-")
        for _ in range(1000):
            try:
                slow.sendall(b"a")
                if slow.recv(1) == b"":
                    return
            except TimeoutError:
                continue
            except OSError:
                return
        raise AssertionError("the server still waits")


def test_an_answer_may_take_its_time(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The deadline is one of the request, not of the work: a live socket outlives it many times."""
    page = server.page().sign_in()
    monkeypatch.setattr(Connection, "seconds", 2.0)
    with page.live() as live:
        first = live.wait("status")
        for _ in range(3):
            live.wait("status", lambda message, first=first: message is not first)
        live.send(type="ping", t=1.0)
        assert live.wait("pong")


@pytest.mark.parametrize(
    "head", ["GET /{0} HTTP/1.1\r\n", "GET / HTTP/1.1\r\nx: {0}\r\n", "GET /?search={0} HTTP/1.1\r\n"]
)
def test_a_head_without_end_is_refused(head: str, server: TestServer) -> None:
    with raw(server) as long:
        long.sendall(head.format("a" * 8 * HEAD_MAX).removesuffix("\r\n").encode())
        found = answer(long)
    assert found.startswith(b"HTTP/1.1 431 "), found[:100]
    assert str(HEAD_MAX).encode() in found


@pytest.mark.parametrize(
    "garbage",
    [b"\x16\x03\x01\x02\x00\x01", b"\x00" * 1000, b"GET / HTTP/9.9\r\n\r\n", b"GET\r\n\r\n", b"\r\n" * 5000 + b"\xff"],
)
def test_what_is_no_request_ends_its_own_connection_only(garbage: bytes, server: TestServer) -> None:
    with raw(server) as bad:
        bad.sendall(garbage)
        assert answer(bad).startswith(b"HTTP/1.1 400 ")
    assert server.page().sign_in().get("/api/session").status_code == 200


def test_of_too_many_connections_those_that_ask_nothing_make_room(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(OPEN, "most", 5)
    with contextlib.ExitStack() as stack:
        many = [stack.enter_context(raw(server)) for _ in range(12)]
        assert [answer(one) for one in many[:6]] == [b""] * 6, "the oldest went"
        page = server.operator()
        with page.live() as live:
            assert live.wait("hello")
            assert page.command("e_stop").status_code == 200, "who asks is served"


def test_of_too_many_that_come_in_one_turn_each_sends_another_one_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """A transport tells its protocol of an abort later, when the next ones have come."""
    count = ConnectionCount()
    monkeypatch.setattr(count, "most", 2)
    monkeypatch.setattr(connections, "OPEN", count)
    config, transports = uvicorn.Config(Mock(), http=Doorstep), [Transport() for _ in range(5)]
    for transport in transports:
        one = Doorstep(config=config, server_state=ServerState(), app_state={}, _loop=Mock())
        one.connection_made(transport)
    assert [transport.aborted for transport in transports] == [1, 1, 1, 0, 0]


class Transport(asyncio.Transport):
    """One that was given a connection and loses it later."""

    aborted = 0

    def get_extra_info(self, name: str, default: object = None) -> object:
        return ("127.0.0.1", 1234) if name == "peername" else default

    def abort(self) -> None:
        self.aborted += 1


@pytest.mark.parametrize(
    "ask", [b"", b"GET / HTTP/1.1\r\nhost: ", b"GET /api/session HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n"]
)
def test_a_connection_that_is_gone_leaves_nothing_to_collect(ask: bytes, server: TestServer) -> None:
    """Else a flood of them makes the garbage collector stop all threads, and an E-STOP waits 200 ms for it."""
    gc.collect()
    gc.disable()
    try:
        for _ in range(20):
            with raw(server) as one:
                one.sendall(ask)
                if ask.endswith(b"\r\n\r\n"):
                    answer(one)
        wait_for(lambda: not _alive(), "the connections to be freed without a collection")
    finally:
        gc.enable()


def _alive() -> list[object]:
    return [one for one in gc.get_objects() if type(one) in (Doorstep, Connection, Flow)]


def test_who_has_not_said_a_whole_head_costs_hardly_anything(server: TestServer) -> None:
    """Parser, flow control and deadline of a request are made for what is one: a flood of half heads has none."""
    with contextlib.ExitStack() as stack:
        many = [stack.enter_context(raw(server)) for _ in range(20)]
        for one in many:
            one.sendall(b"GET /api/session HTTP/1.1\r\nhost: ")
        wait_for(lambda: len(_alive()) >= 20, "all to be there")
        assert {type(one) for one in _alive()} == {Doorstep}
        many[7].sendall(b"x\r\nconnection: close\r\n\r\n")
        assert answer(many[7]).startswith(b"HTTP/1.1 ")
    wait_for(lambda: not _alive(), "all to be gone")


def test_an_address_with_too_many_sockets_is_told_so(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Connection, "seconds", 0.5)
    page, signed_in = server.page(), server.page().sign_in()
    page.cookies.update(signed_in.cookies)
    signed_in.close()
    with page.live() as first, page.live() as second:
        assert first.wait("hello")
        assert second.wait("hello")
        monkeypatch.setattr(OPEN, "most", 2)

        def told() -> bytes:
            with raw(server) as late:
                return answer(late)

        wait_for(lambda: told().startswith(b"HTTP/1.1 503 "), "the last idle connection to be gone")
        assert b"more than 2 connections from 127.0.0.1" in told()
    wait_for(lambda: page.get("/api/session").status_code == 200, "room again")


@pytest.mark.parametrize("upgrade", [False, True], ids=["request", "socket"])
@pytest.mark.parametrize("twice", ["host", "origin", "cookie", "authorization"])
def test_a_header_that_decides_and_comes_twice_is_refused_by_name(
    twice: str, upgrade: bool, server: TestServer, caplog: pytest.LogCaptureFixture
) -> None:
    page = server.page().sign_in()
    cookie = "; ".join(f"{name}={value}" for name, value in page.cookies.items())
    host = server.url.removeprefix("http://")
    given = {"host": host, "cookie": cookie, "origin": server.url, "authorization": "Bearer x"}
    lines = [f"{name}: {value}" for name, value in given.items()] + [f"{twice}: {given[twice]}"]
    if upgrade:
        lines += ["connection: Upgrade", "upgrade: websocket", "sec-websocket-version: 13"]
        lines += ["sec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA=="]
    with raw(server) as connection:
        path = "/ws/live" if upgrade else "/api/session"
        connection.sendall("\r\n".join([f"GET {path} HTTP/1.1", *lines, "connection: close", "", ""]).encode())
        found = connection.recv(65536)
        while b"more than once" not in found and (piece := connection.recv(65536)):
            found += piece
    assert found.startswith(b"HTTP/1.1 400 "), found
    assert f"{twice} is given more than once".encode() in found
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []


def test_a_connection_that_sends_much_does_not_hold_up_another(server: TestServer) -> None:
    """Requests by the thousand in one piece: their answers come one after the other, others' in between."""
    page = server.page().sign_in()
    host = server.url.removeprefix("http://")
    with raw(server) as flood:
        many = f"GET /x HTTP/1.1\r\nhost: {host}\r\n\r\n".encode() * 3000
        threading.Thread(target=flood.sendall, args=[many]).start()
        assert page.get("/api/session").status_code == 200
        found = next(iter(one for one in OPEN._open.get("127.0.0.1", {}) if getattr(one, "pipeline", None)), None)
        waiting = len(found.pipeline) if isinstance(found, Connection) else 0
        assert waiting <= CHUNK_BYTES // 20, "what is not answered waits unread"
        answers = b""
        while answers.count(b"HTTP/1.1 ") < 3000:
            piece = flood.recv(1 << 16)
            assert piece, "the connection was ended"
            answers += piece
