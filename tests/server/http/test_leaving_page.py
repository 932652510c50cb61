"""A page that leaves while the server ends, or stays and says nothing: the server comes to its end in order."""

import socket
import ssl
import threading
from pathlib import Path
from typing import Any

import pytest

from server.app.listening import listen
from server.app.run import uvicorn_server
from server.settings import ServerSettings
from tests.server.certificate import make_pair
from tests.waiting import WAIT_MAX_S, wait_for

UPGRADE = (
    b"GET / HTTP/1.1\r\nhost: x\r\nconnection: Upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n"
    b"sec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
)
CLOSE = b"\x88\x80\x00\x00\x00\x00"
"""A closing message without a reason, masked with zeros."""


class Echo:
    """An application that takes every socket, and notes that it was told of its end."""

    ended = False

    async def __call__(self, scope: dict[str, Any], receive: Any, send: Any) -> None:
        if scope["type"] == "lifespan":
            await receive()
            await send({"type": "lifespan.startup.complete"})
            await receive()
            self.ended = True
            await send({"type": "lifespan.shutdown.complete"})
            return
        await receive()
        await send({"type": "websocket.accept"})
        while (await receive())["type"] != "websocket.disconnect":
            pass


async def at_once() -> None:
    """Nothing is to be done before the end."""


@pytest.mark.process  # openssl's
@pytest.mark.parametrize("leaving", [True, False])
def test_a_server_ends_in_order_whatever_a_page_does(leaving: bool, tmp_path: Path) -> None:
    """Under TLS a page that said that it goes, or was told to, and does not hang up is there for half a minute."""
    cert, key = make_pair(tmp_path)
    listening, app, ready = listen("127.0.0.1", 0), Echo(), threading.Event()
    settings = ServerSettings(state=tmp_path, tls_cert=cert, tls_key=key)
    server = uvicorn_server(app, settings, at_once, ready.set)  # type: ignore[arg-type]  # any application will do
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    trust = ssl.create_default_context(cafile=cert)
    thread.start()
    try:
        assert ready.wait(WAIT_MAX_S)
        bare = socket.create_connection(listening.getsockname(), timeout=WAIT_MAX_S)
        with trust.wrap_socket(bare, server_hostname="127.0.0.1") as page:
            page.sendall(UPGRADE)
            assert b" 101 " in page.recv(4096)
            if leaving:
                page.sendall(CLOSE)
                assert page.recv(4096)[0] == CLOSE[0]
            server.should_exit = True
            wait_for(lambda: not thread.is_alive(), "the server's end")
    finally:
        server.should_exit = True
        thread.join()
    assert app.ended
