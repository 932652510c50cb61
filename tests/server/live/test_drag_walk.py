"""A dragged target on its way, traced: how many functions of ours it enters on either side of the link.

Counted are different functions, each once. Not counted: uvicorn's socket around ours, and who is told of every request
beside its way (`Operator.listen`).
"""

import asyncio
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from pydantic import SecretStr
from starlette.websockets import WebSocket

from controller.link.rig_end import RigEnd
from controller.link.seal import Introduction, Sealer, Seals
from controller.realtime import command_handler as handler_module
from controller.realtime.mailbox import mailbox
from controller.realtime.ring import create_ring
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, RigInfo, Telemetry
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters, Settings
from controller.system.loop_watchdog import LoopWatchdog
from server.access.lease import OperatorLease
from server.access.permit import Permit, Permits
from server.access.sessions import Sessions
from server.access.tokens import Secrets
from server.http.answers import RefusedCounts
from server.http.rates import Rates
from server.live.hub import Viewer
from server.live.socket_handler import SocketContext, SocketHandler
from server.log.events import EventLog
from server.operate import operator as operator_module
from server.operate.operator import Operator
from server.operate.pages import Pages
from server.operate.stopper import Stopper
from server.operate.target_control import TargetContext
from server.plots.feed import Feed, Plots
from server.rig.client import Rig
from server.rig.history import History
from server.settings import ServerSettings
from tests.server.live_server import key_file

SERVER_MAX, RIG_MAX = 25, 30
"""Functions from the socket to zenoh, and from zenoh to the mailbox."""
ROOT = Path(__file__).parents[3]
OURS = tuple(f"{ROOT / room}/" for room in ("controller", "server", "recordings"))
KEY, BOOT = b"k" * 32, 7


class Walk:
    """The functions of ours that a traced thread enters while it is `on`."""

    def __init__(self) -> None:
        self.on = False
        self.entered: dict[str, int] = {}

    def __call__(self, frame: FrameType, event: str, arg: object) -> None:
        file = frame.f_code.co_filename
        if self.on and event == "call" and file.startswith(OURS):
            name = f"{file.removeprefix(f'{ROOT}/')}:{frame.f_code.co_qualname}"
            self.entered[name] = self.entered.get(name, 0) + 1

    @contextmanager
    def here(self) -> Iterator[None]:
        """Trace this thread."""
        before, self.on = sys.getprofile(), True
        sys.setprofile(self)
        try:
            yield
        finally:
            sys.setprofile(before)
            self.on = False


class Wire:
    """In the place of zenoh: what is asked has left, and is not answered."""

    def __init__(self, walk: Walk) -> None:
        self.left, self._walk = threading.Event(), walk

    def get(self, expression: str, **question: Any) -> list[Any]:
        """End of the way."""
        self._walk.on = False
        self.left.set()
        return []


def connected_rig(folder: Path, history: History, wire: Wire) -> Rig:
    """A rig that was met, in FOLLOW, whose link ends at `wire`."""
    settings = ServerSettings(endpoint="tcp/127.0.0.1:9", key_file=key_file(folder), state=folder, token=SecretStr("t"))
    rig, row = Rig(settings, history), np.zeros(1, record_dtype(Telemetry))
    row["mode"] = Mode.FOLLOW
    history.add(row)
    link = rig._link
    link._boot, link._alive, link._flows = BOOT, {str(BOOT)}, True
    link._info = RigInfo.model_construct(boot=BOOT, parameters=RigParameters())
    link._asker._link, link._asker._sealer = wire, Sealer(KEY, BOOT, 1)
    return rig


async def test_a_dragged_target_enters_few_functions_from_socket_to_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(operator_module, "REPEAT_S", 3600.0)
    page, sender, history = Walk(), Walk(), History(1000, 100)
    wire = Wire(sender)
    rig, lease = connected_rig(tmp_path, history, wire), OperatorLease(LoopWatchdog().listened)
    sessions = Sessions(Secrets(token="right", key="k" * 20), "tendril_rig_1")
    stopper = Stopper(rig.stop, lambda: rig.met)
    operator = Operator(rig.send, rig.boot, lambda: history.newest, Settings(), stopper)
    hands = TargetContext(lease, Permits(lease, sessions, rig.operator_timeout), operator, history, EventLog())
    who, inbox = sessions.open("right", "here"), asyncio.Queue[dict[str, str]]()
    lease.acquire(who)
    viewer = Viewer(cast(WebSocket, SimpleNamespace(receive=inbox.get)), who, Feed(Plots(history)))
    listening = asyncio.create_task(
        SocketHandler(viewer, SocketContext(hands, Pages(lease, 10), Rates(), RefusedCounts())).listen()
    )
    try:
        await sent(operator, wire, lambda request: (sys.setprofile(sender), "")[1])
        inbox.put_nowait({"type": "websocket.receive", "text": '{"type": "target", "id": 1, "x": 0.1, "y": 0.02}'})
        sender.on = True
        with page.here():
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        assert await asyncio.to_thread(wire.left.wait, 20)
    finally:
        listening.cancel()
        operator.close()
        rig.close()
    entered = {**page.entered, **sender.entered}
    assert "server/live/socket_handler.py:SocketHandler.hear" in entered and "controller/link/seal.py:_mac" in entered
    assert len(entered) <= SERVER_MAX, "\n".join(entered)
    judged = [name for name in sender.entered if name.startswith("server/access/permit.py:Permit.")]
    assert sum(sender.entered[name] for name in judged) == 1, "one judgement, at the moment of the act"


async def sent(operator: Operator, wire: Wire, objection: Any) -> None:
    """One record leaves, and its permit's `objection` is called in the thread that sends, which then waits again."""
    asked = operator.request(Request.HOLD, Permit(None, objection))
    await asyncio.gather(asyncio.wrap_future(asked), return_exceptions=True)
    while not operator._wake._waiters:  # type: ignore[attr-defined]
        await asyncio.sleep(0.001)
    wire.left.clear()


class Bytes(bytes):
    """As zenoh hands bytes over."""

    def to_bytes(self) -> bytes:  # type: ignore[override]
        """Themselves."""
        return bytes(self)


class Query:
    """A question of a server's, as zenoh hands it to a queryable."""

    def __init__(self, payload: bytes, seal: bytes) -> None:
        self.payload, self.attachment, self.answers = Bytes(payload), Bytes(seal), list[bytes]()

    def __enter__(self) -> None: ...

    def __exit__(self, *given: object) -> None: ...

    def reply(self, key: str, payload: bytes, attachment: bytes) -> None:
        """Keep the answer."""
        self.answers.append(payload)


def test_a_target_enters_few_functions_from_link_to_mailbox(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    walk, queryables, declared = Walk(), dict[str, Any](), SimpleNamespace(undeclare=lambda: None)
    session: Any = SimpleNamespace(
        declare_publisher=lambda *given, **more: declared,
        declare_queryable=lambda key, answer: queryables.setdefault(key, answer) and declared,
        liveliness=lambda: SimpleNamespace(declare_token=lambda key: declared),
    )
    info = RigInfo.model_construct(boot=BOOT, parameters=RigParameters())
    box = mailbox(record_dtype(Command))
    desk = handler_module.CommandHandler(
        info, create_ring("test", BOOT, tmp_path, capacity=8), box, *cast(Any, [None, None, None])
    )
    seals = Seals(KEY, BOOT, "key")
    end = RigEnd(session, "test", seals, desk)
    sealer, keys = Sealer(KEY, BOOT, seals.next_session), end._keys
    payload = Introduction(who="a server").model_dump_json().encode()
    queryables[keys.session](Query(payload, sealer.seal(keys.session, payload)))
    monkeypatch.setattr(handler_module, "post", lambda *given: setattr(walk, "on", False))
    desk._ring.newest()  # loads what is compiled
    record = to_record(Command(boot=BOOT, n=1, target=(0.1, 0.02))).tobytes()
    query = Query(record, sealer.seal(keys.command, record))
    with walk.here():
        queryables[keys.command](query)
    assert query.answers, "the loop of this rig does not tick, and it says so"
    assert "controller/link/seal.py:Seals.admit" in walk.entered
    assert len(walk.entered) <= RIG_MAX, "\n".join(walk.entered)
