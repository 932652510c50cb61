"""What is said while a page is greeted reaches it."""

import asyncio
import time
from types import SimpleNamespace
from typing import Any, cast

from pydantic import BaseModel

from controller.system.scheduler import Scheduler
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.live.hub import Hub, Viewer
from server.live.status import StatusView
from server.operate.pages import Pages
from server.plots.feed import Feed
from server.rig.history import History


class Said(BaseModel):
    """A line of the log."""

    text: str


def test_a_line_that_is_said_while_the_hello_goes_out_comes_after_it() -> None:
    lease = OperatorLease(time.monotonic)
    pages: Pages[Viewer] = Pages(lease, 10)
    hub = Hub(History(), pages, lease, cast(StatusView, None), Scheduler().guard)
    heard: list[str] = []

    async def take(text: str) -> None:
        heard.append(text)
        await asyncio.sleep(0)

    def hello() -> str:
        asyncio.get_running_loop().call_soon(lambda: [page.post(Said(text="stopped")) for page in pages.open])
        return "hello"

    feed = cast(Feed, SimpleNamespace(next=lambda: None, behind=False))
    viewer = Viewer(cast(Any, SimpleNamespace(send_text=take)), cast(Identity, None), feed, status_due=False)

    async def both() -> None:
        serving = asyncio.create_task(hub.serve(viewer, hello))
        for _ in range(10):
            await asyncio.sleep(0)
        serving.cancel()

    asyncio.run(both())
    assert heard == ["hello", '{"text":"stopped"}']
