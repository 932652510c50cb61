"""How many functions of ours a telemetry row is handed to: from the link to the page, and from the link to rerun.

Counted while it happens: a batch with a true proof comes from the link and passes all that stands in its way.
"""

import asyncio
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, cast

import numpy as np

from controller.link import RigClient
from controller.link.client import _Batch
from controller.link.keys import Keys
from controller.link.proof import Prover, Reply
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.write.writer import Recorder
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.live.hub import Hub, Viewer
from server.live.status import StatusView
from server.operate.pages import Pages
from server.plots.feed import Feed
from server.rig.history import History
from tests.recordings.synthetic import rig_info, telemetry_rows

OURS = tuple(f"{Path(__file__).parents[3] / room}/" for room in ("controller", "recordings", "server"))
KEY, BOOT = b"k" * 32, rig_info().boot
ROW = record_dtype(Telemetry)
ROW_BYTES = ROW.itemsize
SENDING = {"Prover.batch"}
"""The rig's end."""
PLOTS = {"extract", "numbers"}
"""Bins for the live plots: made of rows, and no part of the picture of the newest."""
TO_PAGE_MAX, TO_FILE_MAX = 12, 27


@contextmanager
def handed() -> Iterator[set[str]]:
    """Functions of ours that are called with rows, or with what they come in, here and in threads begun meanwhile."""
    names = set[str]()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(OURS) and any(map(_is_row, frame.f_locals.values())):
            names.add(frame.f_code.co_qualname)

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        yield names
    finally:
        sys.setprofile(None)
        threading.setprofile(cast(Any, None))


def _is_row(value: object) -> bool:
    if isinstance(value, bytes):
        return len(value) > ROW_BYTES  # no key and no proof
    return isinstance(value, Sample | _Batch) or (isinstance(value, np.ndarray) and value.dtype == ROW)


class Sample:
    """As zenoh hands it over."""

    def __init__(self, attachment: bytes, payload: bytes) -> None:
        self.attachment, self.payload = Bytes(attachment), Bytes(payload)


class Bytes(bytes):
    def to_bytes(self, *_: Any, **__: Any) -> bytes:
        return bytes(self)


class AtOnce:
    """Instead of the link's queue: what is put is taken at once, by who puts it."""

    def __init__(self, take: Callable[[Any], None]) -> None:
        self._take, self.over = take, False

    def put(self, batch: Any) -> None:
        self.over = batch is None
        if not self.over:
            self._take(batch)

    def qsize(self) -> int:
        return 0

    def get(self, timeout: float) -> Any:
        time.sleep(min(timeout, 0.05))
        if self.over:
            return None
        raise queue.Empty


@contextmanager
def link(on_rows: Callable[[Any], None]) -> Iterator[Callable[[Any], None]]:
    """A link that has met its rig; what it gives takes rows as the rig would send them."""
    client = RigClient("tcp/127.0.0.1:9", "bench", on_rows, key=KEY, commands=False)
    prover, expression = Prover(KEY, BOOT), Keys("bench").telemetry
    client._boot, client._queue = BOOT, cast(Any, AtOnce(client._take))
    client._begin(Reply(BOOT, 0, time.monotonic_ns(), ""), time.monotonic(), rig_info())

    def send(rows: Any) -> None:
        rows["t_ns"] = time.monotonic_ns() + 1_000_000 * np.arange(len(rows))
        payload = rows.tobytes()
        client._on_batch(Sample(prover.batch(expression, payload), payload))

    try:
        yield send
    finally:
        client.close()


def test_from_the_link_to_the_page() -> None:
    history, lease, sent = History(), OperatorLease(time.monotonic), list[bytes]()
    pages: Pages[Viewer] = Pages(lease, 10)
    hub = Hub(history, pages, lease, cast(StatusView, None), Scheduler().guard)

    async def take(frame: bytes) -> None:
        sent.append(frame)

    feed = cast(Feed, SimpleNamespace(next=lambda: None))
    viewer = Viewer(cast(Any, SimpleNamespace(send_bytes=take)), cast(Identity, None), feed, status_due=False)
    pages.open.add(viewer)
    rows = telemetry_rows(48)
    with link(history.add) as send:
        send(rows[:32])
        with handed() as names:
            send(rows[32:])
            hub.frame()
            asyncio.run(hub._send(viewer))
    assert sent[-1].endswith(rows[-1:].tobytes())
    names -= SENDING | PLOTS
    assert len(names) <= TO_PAGE_MAX, sorted(names)


def test_from_the_link_to_rerun(tmp_path: Path) -> None:
    rows = telemetry_rows(600)
    with handed() as names:
        recorder = Recorder(tmp_path)
        recorder.start("path", rig_info(), Settings())
        names.clear()
        with link(recorder.rows) as send:
            send(rows)
            done = recorder.stop()
        recorder.close()
    assert done.rows == 600
    names -= SENDING
    assert len(names) <= TO_FILE_MAX, sorted(names)
