"""The server's end of the link: every telemetry row in order, commands with the rig's answer, and who the rig is."""

import json
import logging
import queue
import statistics
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import zenoh

from controller.errors import LayoutMismatch, ParameterError, RigUnreachable
from controller.layout import layout_hash, record_dtype, require_same_layout, to_record
from controller.link.keys import Keys, open_session
from controller.link.stream import RowStream
from controller.messages import Command, CommandReply, RigInfo, Telemetry, TwinFaults

log = logging.getLogger(__name__)

QUEUED_BATCHES = 3000
"""Batches kept for a slow reader: 30 s, as long as the rig's ring could refill them."""
QUIET = 1.0
"""Seconds without a batch after which the rig counts as not connected [s]."""
TIMED_OUT = "Timeout"
"""What zenoh itself puts into an error reply when nobody answered in time."""
TIMEOUT = 0.5
"""Longest wait for an answer [s]; the rig itself waits 50 ms for its loop."""
PLAN_TIMEOUT = 5.0
"""The same for a reference, which may be of 5 MB [s]."""


class RigClient:
    """One connection to one rig, kept for ever: it survives restarts of the rig. Every method is thread safe.

    `on_rows(rows)` gets Telemetry arrays, gapless and in order, and `on_boot(info)` every new life of the rig before
    its rows; both run in one thread of this client, and what they raise is logged.
    """

    def __init__(
        self,
        endpoint: str,
        rig_id: str,
        on_rows: Callable[[np.ndarray], None],
        on_boot: Callable[[RigInfo], None] = lambda info: None,
    ) -> None:
        """Connect in the background; `endpoint` like "tcp/127.0.0.1:7557"."""
        self._keys = Keys(rig_id)
        self._on_boot = on_boot
        self._stream = RowStream(self._missing, on_rows)
        self._queue: queue.Queue[tuple[int, bytes] | None] = queue.Queue(QUEUED_BATCHES)
        self._boot: int | None = None
        self._info: RigInfo | None = None
        self._refused: LayoutMismatch | None = None
        self._alive: set[str] = set()
        self._logged: set[type[Exception]] = set()
        self._last = time.monotonic()
        self._round_trips: deque[float] = deque(maxlen=50)
        self._session = open_session(connect=endpoint)
        self._worker = threading.Thread(target=self._work, name="rig-link", daemon=True)
        self._worker.start()
        # Direct: no thread of Python's for zenoh, which would keep an interpreter from ending without `close`.
        on_batch, on_alive = (
            zenoh.handlers.Callback(call, indirect=False) for call in (self._on_batch, self._on_alive)
        )
        self._session.declare_subscriber(self._keys.telemetry, on_batch)
        self._session.liveliness().declare_subscriber(self._keys.alive("*"), on_alive, history=True)

    @property
    def info(self) -> RigInfo | None:
        """Who the rig is; None before the first contact. Kept while the rig is gone."""
        return self._info

    @property
    def connected(self) -> bool:
        """The rig is alive, speaks our layout and sent something within the last second."""
        met = self._info is not None and self._refused is None
        return met and self._keys.alive(str(self._boot)) in self._alive and self.age() < QUIET

    @property
    def gaps(self) -> int:
        """Rows lost for good: overwritten in the ring before they could be fetched."""
        return self._stream.gaps

    @property
    def refused(self) -> LayoutMismatch | None:
        """Why nothing is accepted from this rig, if so."""
        return self._refused

    def age(self) -> float:
        """Time since the last batch, or since this client began [s]."""
        return time.monotonic() - self._last

    def rtt(self) -> float:
        """Median time from command to the loop's answer over the last 50 commands [s]; 0 before the first."""
        return statistics.median(self._round_trips) if self._round_trips else 0.0

    def command(self, command: Command) -> CommandReply:
        """Send `command` and wait for the loop's answer; a refusal is in the reply.

        Raises RigUnreachable without an answer, ParameterError if the rig found the record malformed, LayoutMismatch
        if rig and server are different versions.
        """
        if self._refused:
            raise self._refused
        started = time.monotonic()
        reply = CommandReply.model_validate_json(self._ask(self._keys.command, to_record(command).tobytes()))
        self._round_trips.append(time.monotonic() - started)
        return reply

    def replay(self, first: int, count: int) -> np.ndarray:
        """Telemetry rows of ticks [first, first + count) that the rig's ring still holds."""
        payload = np.array([first, count], np.int64).tobytes()
        return np.frombuffer(self._ask(self._keys.replay, payload), record_dtype(Telemetry))

    def plan(self, points: np.ndarray, again: int = 0, ticks: int | None = None) -> int:
        """Send (n, 2) points [m], one a tick, as the reference of the next TRACK run; returns their number.

        Point `again` comes after the last one, and `ticks` points are followed in all: each once where that is None.
        Raises ParameterError with the rig's words if it cannot take them, because of their values or of its mode.
        """
        words = np.array([again, len(points) if ticks is None else ticks], np.int64)
        payload = words.tobytes() + np.ascontiguousarray(points, np.float64).tobytes()
        answer = self._ask(self._keys.reference, payload, PLAN_TIMEOUT)
        return int.from_bytes(answer, "little")

    def faults(self, wanted: TwinFaults | None = None) -> TwinFaults:
        """Inject faults into the twin's sensing; None only asks. Those in force; ParameterError on hardware."""
        payload = wanted.model_dump_json().encode() if wanted else b""
        return TwinFaults.model_validate_json(self._ask(self._keys.faults, payload))

    def close(self) -> None:
        """End the connection; no callback comes after this."""
        self._session.close()
        while self._worker.is_alive() and self._worker is not threading.current_thread():
            try:
                self._queue.put_nowait(None)
            except queue.Full:
                self._queue.get_nowait()
            self._worker.join(0.1)

    def _ask(self, key: str, payload: bytes = b"", timeout: float = TIMEOUT) -> bytes:
        """Answer of the queryable `key`."""
        try:
            replies = list(self._session.get(key, payload=payload, timeout=timeout))
        except zenoh.ZError as error:
            raise RigUnreachable(f"rig {self._keys.rig!r} cannot be asked: {error}") from error
        for reply in replies:
            if reply.ok:
                return bytes(reply.ok.payload.to_bytes())
            text = reply.err.payload.to_string()
            if text != TIMED_OUT:
                raise ParameterError(text)
        raise RigUnreachable(f"rig {self._keys.rig!r} did not answer within {timeout:g} s")

    def _on_batch(self, sample: Any) -> None:
        """In a thread of zenoh: only note and queue; a full queue drops the batch, a replay brings it back."""
        self._last = time.monotonic()
        try:
            boot = int.from_bytes(sample.attachment.to_bytes(), "little")
            self._queue.put_nowait((boot, sample.payload.to_bytes()))
        except queue.Full:
            pass

    def _on_alive(self, sample: Any) -> None:
        change = self._alive.add if sample.kind == zenoh.SampleKind.PUT else self._alive.discard
        change(str(sample.key_expr))

    def _work(self) -> None:
        while (item := self._queue.get()) is not None:
            try:
                self._take(*item)
            except RigUnreachable as error:
                log.info("%s", error)
            except Exception as error:
                self._complain(error)

    def _complain(self, error: Exception) -> None:
        """Log with the traceback once for every kind: there are 100 batches a second."""
        kind = type(error)
        log.error("telemetry batch failed: %s: %s", kind.__name__, error, exc_info=kind not in self._logged)
        self._logged.add(kind)

    def _take(self, boot: int, payload: bytes) -> None:
        if self._boot != boot:
            self._meet(boot)
        if self._boot == boot and self._refused is None:
            self._stream.take(np.frombuffer(payload, record_dtype(Telemetry)))

    def _meet(self, boot: int) -> None:
        """A new life of the rig: do we speak the same layout, who is it, and where do its rows begin?"""
        answer = json.loads(self._ask(self._keys.info))
        if answer["boot"] != boot:
            return
        first_contact, self._boot, self._refused = self._boot is None, boot, None
        try:
            require_same_layout(layout_hash(Command, Telemetry), answer["layout"])
        except LayoutMismatch as error:
            self._refused = error
            log.error("rig %r refused: %s", self._keys.rig, error)
            return
        self._info = RigInfo.model_validate(answer)
        self._stream.expect(None if first_contact else 0)
        self._on_boot(self._info)

    def _missing(self, first: int, count: int) -> np.ndarray:
        try:
            return self.replay(first, count)
        except RigUnreachable:
            if self.connected:  # only slow: with the next batch the rows are asked for again
                raise
            return np.empty(0, record_dtype(Telemetry))
