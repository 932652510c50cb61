"""The live socket: hello with the log so far, then everything live, until either side closes."""

import contextlib
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from controller.schema.layout import fields
from controller.schema.messages import Telemetry
from controller.system.tasks import until_one_ends
from server.access.sessions import Sessions
from server.http.connections import URGENT
from server.http.given import given
from server.http.problems import answer
from server.http.rates import POLICY
from server.http.who import Me
from server.live.hub import Hub, Viewer
from server.live.messages import Health, Hello
from server.live.socket_handler import SocketContext, SocketHandler
from server.live.status import GivenStatusView
from server.operate.pages import Crowded, GivenPages, Pages
from server.plots.feed import Feed, Plots
from server.rig.channels import CHANNELS
from server.rig.client import Rig
from server.settings import ServerSettings

router = APIRouter()


@router.get("/api/live", status_code=204, tags=["session"])
async def may_look_on(pages: GivenPages, who: Me) -> None:
    """Whether a page may open /ws/live now; 503 when too many look on. A browser hides why its socket was refused."""
    with pages.seat(who):
        pass


@router.get("/api/health", tags=["rig"])
async def read_health(view: GivenStatusView) -> Health:
    """Whether the rig is heard, and how fast it answers."""
    return view.health()


@dataclass(frozen=True)
class Live:
    """What every live socket needs."""

    hub: Hub
    pages: Pages[Viewer]
    plots: Plots
    sessions: Sessions
    rig: Rig
    context: SocketContext
    settings: ServerSettings

    async def serve(self, viewer: Viewer) -> None:
        """Talk with the page of `viewer` until either side closes, or its session ends."""
        await viewer.socket.accept()
        handler = SocketHandler(viewer, self.context)
        viewer.socket.scope["state"][URGENT] = handler.urgent
        ended = self.sessions.ended(viewer.who)
        await until_one_ends(self.hub.serve(viewer, lambda: self._hello(viewer)), handler.listen(), ended)
        handler.leave()
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await viewer.socket.close(POLICY)

    def _hello(self, viewer: Viewer) -> str:
        hello = Hello(
            session=self.context.control.lease.session(viewer.who, self.settings.unprotected),
            layout=fields(Telemetry),
            channels=CHANNELS,
            page=viewer.name,
            rig=self.rig.info,
            log=list(self.context.control.events.recent),
        )
        return hello.model_dump_json()


@router.websocket("/ws/live")
async def live(socket: WebSocket, here: Annotated[Live, given(Live)], who: Me) -> None:
    """Serve one page; 503 when too many look on."""
    try:
        with here.pages.seat(who):
            await here.serve(Viewer(socket, who, Feed(here.plots)))
    except Crowded as error:
        await socket.send_denial_response(answer(error))
