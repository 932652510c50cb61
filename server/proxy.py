"""Viser on our own origin: HTTP and WebSocket at /viser, its own panel hidden, every upward message judged."""

import asyncio
import contextlib
import gzip
import hashlib

import httpx
from fastapi import APIRouter, Request, Response, WebSocket
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from server.deps import Me, Parts
from server.drag import Drag
from server.frames import TELL_ESCAPE
from server.tasks import until_one_ends

router = APIRouter(include_in_schema=False)

HIDE = b"""<style>
[data-floating-window], .mantine-Notifications-root, .mantine-Paper-root[style*=fixed] { display: none !important }
</style>"""
"""Viser offers no way to hide its panel (another one in a narrow frame) and its notices."""


@router.get("/viser")
@router.get("/viser/{path:path}")
async def page(request: Request, parts: Parts, path: str = "") -> Response:
    """Viser's page and files; `?view=top` or `?view=oblique` chooses where the camera starts."""
    query = parts.scene.view_query(request.query_params.get("view", ""))
    if query is not None:
        return RedirectResponse(f"/viser/?{query}", 307)
    async with httpx.AsyncClient(trust_env=False) as client:
        try:
            upstream = await client.get(
                f"http://127.0.0.1:{parts.scene.port}/{path}", headers={"accept-encoding": "identity"}
            )
        except httpx.InvalidURL:
            return Response(status_code=404)
        except httpx.HTTPError as error:
            return PlainTextResponse(f"The 3D view does not answer: {error}", 502)
    body = upstream.content.replace(b"</head>", HIDE + TELL_ESCAPE + b"</head>", 1)
    tag = f'"{hashlib.sha256(body).hexdigest()[:16]}"'
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"etag": tag})
    body = await asyncio.to_thread(gzip.compress, body, 5)
    headers = {"content-encoding": "gzip", "etag": tag, "cache-control": "no-cache"}
    return Response(body, upstream.status_code, headers, upstream.headers.get("content-type"))


@router.websocket("/viser")
@router.websocket("/viser/{path:path}")
async def socket(browser: WebSocket, parts: Parts, who: Me) -> None:
    """Viser's socket: downward as it is, upward only what `Drag` lets through."""
    drag = Drag(who, parts.lease, parts.operator, parts.scene)
    protocols = [Subprotocol(name) for name in browser.scope["subprotocols"]]
    url = f"ws://127.0.0.1:{parts.scene.port}/"
    try:
        async with connect(
            url, subprotocols=protocols, max_size=None, compression=None, ping_interval=None, proxy=None
        ) as viser:
            await browser.accept(subprotocol=viser.subprotocol)
            await until_one_ends(_down(viser, browser), _up(browser, viser, drag))
    except (WebSocketException, OSError):
        pass  # viser is closing, or did not like the subprotocol
    finally:
        drag.end()
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await browser.close()


async def _down(viser: ClientConnection, browser: WebSocket) -> None:
    async for message in viser:
        await (browser.send_bytes(message) if isinstance(message, bytes) else browser.send_text(message))


async def _up(browser: WebSocket, viser: ClientConnection, drag: Drag) -> None:
    while (message := await browser.receive())["type"] != "websocket.disconnect":
        if (judged := drag.judge(message.get("bytes"))) is not None:
            await viser.send(judged)
