"""Viser on our own origin: HTTP and WebSocket at /viser, its own panel hidden, every upward message judged."""

import asyncio
import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import httpx
from fastapi import APIRouter, Request, Response, WebSocket
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from controller.system.tasks import until_one_ends
from server.access.sessions import Sessions
from server.http.given import given
from server.http.rates import POLICY, Rates, Verdict
from server.http.who import Identity, Me
from server.operate.messages import Refused
from server.operate.pages import Pages
from server.operate.target_control import TargetContext
from server.scene.drag import Drag
from server.scene.messages import Scheme, SeatId, View
from server.scene.scene import GivenScene, Scene
from server.scene.view_session import ViewSession
from server.scene.viser_files import GivenViserFiles

router = APIRouter(include_in_schema=False)


@dataclass(frozen=True)
class Way:
    """From a browser's socket to viser's, and back."""

    scene: Scene
    context: TargetContext
    rates: Rates
    sessions: Sessions
    pages: Pages[Any]

    async def connect(self, browser: WebSocket, who: Identity, session: ViewSession | None) -> None:
        """Pass messages on: downward as they are, upward only what `Drag` lets through."""
        drag = Drag(who, self.context, self.scene, partial(self._refused, who))
        verdict = partial(self.rates.message, f"viser {who.client}")
        protocols = [Subprotocol(name) for name in browser.scope["subprotocols"]]
        url = f"ws://127.0.0.1:{self.scene.port}/"
        try:
            async with connect(
                url, subprotocols=protocols, max_size=None, compression=None, ping_interval=None, proxy=None
            ) as viser:
                await browser.accept(subprotocol=viser.subprotocol)
                with _attached(self.scene, viser.local_address[1], session):
                    up = _up(browser, viser, drag, verdict)
                    await until_one_ends(_down(viser, browser), up, self.sessions.ended(who))
        except (WebSocketException, OSError):
            pass  # viser is closing, or did not like the subprotocol
        finally:
            drag.leave()
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await browser.close()

    def _refused(self, who: Identity, reason: str) -> None:
        self.pages.tell_session(who, Refused(id=0, detail=reason))


GivenWay = Annotated[Way, given(Way)]


@router.get("/viser/seat/{id}/")
async def seat_page(
    request: Request,
    scene: GivenScene,
    files: GivenViserFiles,
    who: Me,
    id: SeatId,
    view: View | None = None,
    scheme: Scheme | None = None,
) -> Response:
    """Viser's page in a view session of its own; `view` and `scheme` choose camera and ground."""
    session = scene.view_session(id, who)
    if scheme is not None:
        session.look(scheme, view)
    if view is not None:
        return RedirectResponse(f"/viser/seat/{id}/?{scene.camera(view).query}", 307)
    return await viser_file(request, files)


@router.get("/viser")
@router.get("/viser/{path:path}")
async def viser_file(request: Request, files: GivenViserFiles, path: str = "") -> Response:
    """Viser's page and files."""
    try:
        file = await files.file(path)
    except httpx.InvalidURL:
        return Response(status_code=404)
    except httpx.HTTPError as error:
        return PlainTextResponse(f"The 3D view does not answer: {error}", 502)
    if request.headers.get("if-none-match") == file.tag:
        return Response(status_code=304, headers={"etag": file.tag})
    headers = {"content-encoding": "gzip", "etag": file.tag, "cache-control": "no-cache"}
    return Response(file.body, file.status, headers, file.media or None)


@router.websocket("/viser/seat/{id}")
async def seat_socket(browser: WebSocket, way: GivenWay, who: Me, id: SeatId) -> None:
    """Viser's socket of the page of this view session."""
    await way.connect(browser, who, way.scene.view_session(id, who))


@router.websocket("/viser")
@router.websocket("/viser/{path:path}")
async def viser_socket(browser: WebSocket, way: GivenWay, who: Me) -> None:
    """Viser's socket of a page without a view session: it sees the live scene as all do."""
    await way.connect(browser, who, None)


@contextlib.contextmanager
def _attached(scene: Scene, port: int, session: ViewSession | None) -> Iterator[None]:
    """While this lasts, viser's client that connected from `port` belongs to `session`."""
    if session is not None:
        scene.expect(port, session)
    try:
        yield
    finally:
        scene.gone(port)


async def _down(viser: ClientConnection, browser: WebSocket) -> None:
    async for message in viser:
        await (browser.send_bytes(message) if isinstance(message, bytes) else browser.send_text(message))


async def _up(browser: WebSocket, viser: ClientConnection, drag: Drag, verdict: Callable[[], Verdict]) -> None:
    while (message := await browser.receive())["type"] != "websocket.disconnect":
        if (found := verdict()) == Verdict.FLOOD:
            return await browser.close(POLICY)
        if found != Verdict.HEARD:
            await asyncio.sleep(0)
        elif (judged := drag.judge(message.get("bytes"))) is not None:
            await viser.send(judged)
