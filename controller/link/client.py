"""The server's end of the link: every telemetry row in order, commands with the rig's answer, and who the rig is."""

import json
import logging
import queue
import statistics
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import zenoh
from pydantic import ValidationError

from controller.errors import LayoutMismatch, RigUnreachable, TendrilError
from controller.layout import record_dtype, to_record
from controller.link.asker import Asker
from controller.link.keys import Keys, open_session
from controller.link.stream import RowStream
from controller.link.version import mismatch, require_same
from controller.messages import Command, CommandReply, RigInfo, Telemetry, TwinFaults
from controller.modes import Request

log = logging.getLogger(__name__)

QUEUED_BATCHES = 3000
"""Batches kept for a slow reader: 30 s, as long as the rig's ring could refill them."""
QUIET = 1.0
"""Seconds without a batch after which the rig counts as not connected [s]."""
PLAN_TIMEOUT = 5.0
"""Longest wait for the answer to a reference, which may be of 5 MB [s]."""
LEAVE_TIMEOUT = 0.2
"""The same for a good-bye [s]."""


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
        *,
        key: bytes | None = None,
        tls: Path | None = None,
    ) -> None:
        """Connect in the background; `endpoint` like "tcp/127.0.0.1:7557".

        `key` is the rig's, without which nothing can be changed; `tls` as of `open_session`.
        """
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
        self._session = open_session(connect=endpoint, tls=tls)
        self._asker = Asker(self._session, self._keys, key)
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

    @property
    def trouble(self) -> TendrilError | None:
        """Why this rig takes nothing from us: another version, another key, another server; None when it does."""
        return self._refused or self._asker.trouble

    def age(self) -> float:
        """Time since the last batch, or since this client began [s]."""
        return time.monotonic() - self._last

    def rtt(self) -> float:
        """Median time from command to the loop's answer over the last 50 commands [s]; 0 before the first."""
        return statistics.median(self._round_trips) if self._round_trips else 0.0

    def command(self, command: Command) -> CommandReply:
        """Send `command` and wait for the loop's answer; a refusal is in the reply.

        Raises RigUnreachable without an answer, ParameterError if the rig found the record malformed, LayoutMismatch
        if rig and server are different versions, KeyRefused if our key is not the rig's, RigHeld if another server
        commands it.
        """
        if self._refused:
            raise self._refused
        started = time.monotonic()
        reply = CommandReply.model_validate_json(
            self._asker.ask_sealed(
                self._keys.command, to_record(command).tobytes(), any_server=command.request == Request.E_STOP
            )
        )
        self._round_trips.append(time.monotonic() - started)
        return reply

    def replay(self, first: int, count: int) -> np.ndarray:
        """Telemetry rows of ticks [first, first + count) that the rig's ring still holds."""
        payload = np.array([first, count], np.int64).tobytes()
        return np.frombuffer(self._asker.ask(self._keys.replay, payload), record_dtype(Telemetry))

    def plan(self, points: np.ndarray, again: int = 0, ticks: int | None = None) -> int:
        """Send (n, 2) points [m], one a tick, as the reference of the next TRACK run; returns their number.

        Point `again` comes after the last one, and `ticks` points are followed in all: each once where that is None.
        Raises ParameterError with the rig's words if it cannot take them, because of their values or of its mode.
        """
        words = np.array([again, len(points) if ticks is None else ticks], np.int64)
        payload = words.tobytes() + np.ascontiguousarray(points, np.float64).tobytes()
        answer = self._asker.ask_sealed(self._keys.reference, payload, PLAN_TIMEOUT)
        return int.from_bytes(answer, "little")

    def faults(self, wanted: TwinFaults | None = None) -> TwinFaults:
        """Inject faults into the twin's sensing; None only asks. Those in force; ParameterError on hardware."""
        if wanted is None:
            return TwinFaults.model_validate_json(self._asker.ask(self._keys.faults))
        payload = wanted.model_dump_json().encode()
        return TwinFaults.model_validate_json(self._asker.ask_sealed(self._keys.faults, payload))

    def close(self) -> None:
        """End the connection; no callback comes after this. Another server may command the rig at once."""
        self._asker.leave(LEAVE_TIMEOUT)
        self._session.close()
        while self._worker.is_alive() and self._worker is not threading.current_thread():
            try:
                self._queue.put_nowait(None)
            except queue.Full:
                self._queue.get_nowait()
            self._worker.join(0.1)

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
        answer = json.loads(self._asker.ask(self._keys.info))
        if answer["boot"] != boot:
            return
        first_contact, self._boot, self._refused = self._boot is None, boot, None
        self._asker.forget()
        try:
            self._info = self._read(answer)
        except LayoutMismatch as error:
            self._refused = error
            log.error("%s", error)
            return
        self._stream.expect(None if first_contact else 0)
        self._on_boot(self._info)

    def _read(self, answer: Any) -> RigInfo:
        """Who the rig is; LayoutMismatch if it is built from other definitions than we are."""
        who, theirs, layout = f"rig {self._keys.rig!r}", str(answer.get("version")), str(answer.get("layout"))
        require_same(who, theirs, layout, "this server")
        try:
            return RigInfo.model_validate(answer)
        except ValidationError as error:  # same records, other parameters
            raise mismatch(who, theirs, layout, "this server") from error

    def _missing(self, first: int, count: int) -> np.ndarray:
        try:
            return self.replay(first, count)
        except RigUnreachable:
            if self.connected:  # only slow: with the next batch the rows are asked for again
                raise
            return np.empty(0, record_dtype(Telemetry))
