"""The listening socket: how many connections one turn of the network's loop accepts."""

import asyncio
import contextlib
import socket

import uvloop

from server.app.listening import AT_ONCE, handles, listen

CONNECTIONS = 4 * AT_ONCE


def test_one_turn_of_the_loop_accepts_many_connections() -> None:
    listening = listen("127.0.0.1", 0)
    with contextlib.ExitStack() as opened:
        for _ in range(CONNECTIONS):
            opened.enter_context(socket.create_connection(listening.getsockname()))
        turns = uvloop.run(turns_to_accept(listening))
    assert turns < CONNECTIONS / 4, "with one handle it is as many turns as connections"


async def turns_to_accept(listening: socket.socket) -> int:
    made: list[asyncio.BaseTransport] = []

    class Peer(asyncio.Protocol):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            made.append(transport)

    loop = asyncio.get_running_loop()
    servers = [await loop.create_server(Peer, sock=one) for one in handles(listening)]
    turns = 0
    while len(made) < CONNECTIONS and turns < 4 * CONNECTIONS:
        turns += 1
        await asyncio.sleep(0)
    for server in servers:
        server.close()
    for transport in made:
        transport.close()
    await asyncio.sleep(0)
    return turns
