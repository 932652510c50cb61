"""The server's end of the link: every telemetry row in order, commands with the rig's answer, and who the rig is.

A batch is taken if it is proven to be the rig's (proof.py), newer than all before it, of the boot that answered us, and
follows from the last one (stream.py). What is refused is counted, and stands in the log once a minute at most.
"""

import contextlib
import json
import logging
import queue
import statistics
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import zenoh
from pydantic import ValidationError

from controller.errors import KeyRefused, LayoutMismatch, RigUnreachable, TendrilError, Unproven
from controller.link.asker import Asker
from controller.link.guard import probe
from controller.link.keys import NAME_MAX_BYTES, REPLAY_MAX, Keys, open_session
from controller.link.planned import PlannedRows, encoded
from controller.link.proof import PROOF_BYTES, Reply, read_batch
from controller.link.refusals import Refusals
from controller.link.stream import Pace, RowStream
from controller.link.version import mismatch, require_same
from controller.schema.hardware import Drivers
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, CommandReply, RigInfo, Telemetry, TwinFaults, TwinTime
from controller.schema.modes import Request
from controller.system.thread import SupervisedThread

log = logging.getLogger(__name__)

QUEUED_BATCHES = 1800
"""Batches kept for a slow reader: 30 s, as long as the rig's ring could refill them."""
ROW = record_dtype(Telemetry)
QUIET_S, GONE_S = 0.6, 1.0
"""Without a batch for so long users are told that the rig is gone; and the link itself gives it up."""
LOOK_S = 1.0
"""Between two looks at why nothing comes, where nothing does."""
DEAD_LIVES = 16
"""Lives of the rig that are over, of which recorded batches are refused without another question."""
PLAN_TIMEOUT = 5.0
"""Longest wait for the answer to a reference, which may be of 7 MB [s]."""
LEAVE_TIMEOUT = 0.2
"""The same for a good-bye [s]."""


M = TypeVar("M", TwinFaults, TwinTime)


class _Batch(NamedTuple):
    """Proven to be the rig's, at some time."""

    boot: int
    number: int
    arrived: float
    payload: bytes


class RigClient:
    """One connection to one rig, kept for ever: it survives restarts of the rig. Every method is thread safe.

    `on_rows(rows)` gets Telemetry arrays, gapless and in order, and `on_boot(info)` every new boot of the rig before
    its rows; both run in one thread of this client, and what they raise is logged.
    """

    def __init__(
        self,
        endpoint: str,
        rig_id: str,
        on_rows: Callable[[np.ndarray], None],
        on_boot: Callable[[RigInfo], None] = lambda info: None,
        *,
        key: bytes,
        tls: Path | None = None,
        commands: bool = True,
    ) -> None:
        """Connect in the background; `endpoint` like "tcp/127.0.0.1:7557".

        `key` is the rig's, without which it opens no session; `tls` as of `open_session`. `commands`: whether we are
        one who may have to stop the rig at once.
        """
        self._commands = commands
        self._keys, self._key, self._endpoint = Keys(rig_id), key, endpoint
        self._on_boot = on_boot
        self._stream = RowStream(self._missing, on_rows)
        self._queue: queue.SimpleQueue[_Batch | None] = queue.SimpleQueue()
        self._boot: int | None = None
        self._dead: deque[int] = deque(maxlen=DEAD_LIVES)
        self._heard = self._floor = 0
        self._hearing = threading.Lock()
        self._pace: Pace | None = None
        self._flows = self._paused = False
        self._kept_out: KeyRefused | None = None
        self._refusals = Refusals(rig_id, what="batch")
        self._info: RigInfo | None = None
        self._refused: LayoutMismatch | None = None
        self._alive: set[str] = set()
        self._logged: set[type[Exception]] = set()
        self._last = time.monotonic()
        self._round_trips: deque[float] = deque(maxlen=50)
        self._session = open_session(key=key, connect=endpoint, tls=tls)
        self._asker = Asker(self._session, self._keys, key)
        self._stopper = Asker(self._session, self._keys, key, urgent=True)
        self.worker = SupervisedThread("rig-link", self._work)
        self.worker.start()
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

    def boot(self, quiet_s: float | None = None) -> int | None:
        """The boot of the rig that is connected: alive, of our layout, and heard within QUIET_S, with rows that were
        taken. None while there is none.
        """
        met = self._info is not None and self._refused is None and self._flows
        heard = met and str(self._boot) in self._alive and time.monotonic() - self._last < (quiet_s or QUIET_S)
        return self._boot if heard else None

    @property
    def connected(self) -> bool:
        """Whether there is one, or one that is only slow."""
        return self.boot(GONE_S) is not None

    @property
    def paused(self) -> bool:
        """The last batch said that the twin's time stands still."""
        return self._paused

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
        return self._refused or self._kept_out or self._asker.trouble

    def age(self) -> float:
        """Time since the last batch that was the rig's, and new, or since this client began [s]."""
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
        started, stops = time.monotonic(), command.request == Request.E_STOP
        try:
            answer = self._asker.ask_sealed(self._keys.command, to_record(command).tobytes(), any_server=stops)
        except RigUnreachable as error:
            raise self._kept_out or error from error
        reply = CommandReply.model_validate_json(answer)
        self._round_trips.append(time.monotonic() - started)
        return reply

    def stop(self, number: int, boot: int, by: str = "") -> CommandReply:
        """E-STOP, past all that waits here, on the link and at the rig; the reply's n is the request's number. The rig
        keeps who pressed, `by`, of which as much as NAME_MAX_BYTES.

        `number` names one press, and is unlike those of all other servers: with the same one it acts once, however
        often it is sent. A rig that started again since, whose boot id is not `boot`, refuses it, and is vented. Raises
        as `command`, but never RigHeld.
        """
        return CommandReply.model_validate_json(self._stopper.ask_sealed(self._keys.stop, press(number, boot, by)))

    def send_stop(self, number: int, boot: int, by: str = "") -> Callable[[], CommandReply] | None:
        """Send the same from any thread, without waiting; what then waits for its answer, None if it was not sent."""
        answer = self._stopper.send_sealed(self._keys.stop, press(number, boot, by))
        if answer is None:
            return None
        return lambda: CommandReply.model_validate_json(answer().payload)

    def replay(self, first: int, count: int) -> np.ndarray:
        """Telemetry rows of ticks [first, first + count) that the rig's ring still holds."""
        payload = np.array([first, count], np.int64).tobytes()
        return np.frombuffer(self._asker.ask(self._keys.replay, payload).payload, ROW)

    def replay_all(self, first: int, stop: int) -> np.ndarray:
        """The same of [first, stop), however many."""
        parts = [np.empty(0, ROW)]
        while first < stop:
            rows = self.replay(first, min(REPLAY_MAX, stop - first))
            parts.append(rows)
            first = int(rows["tick"][-1]) + 1 if len(rows) else first + REPLAY_MAX  # all of these are gone
        found = np.concatenate(parts)
        return found[found["tick"] < stop]

    def plan(self, rows: PlannedRows) -> int:
        """Send `rows` as the reference of the next TRACK run; returns their number.

        Raises ParameterError with the rig's words if it cannot take them, because of their values, of what they ask of
        the arm, or of its mode.
        """
        answer = self._asker.ask_sealed(self._keys.reference, encoded(rows), PLAN_TIMEOUT)
        return int.from_bytes(answer, "little")

    def faults(self, wanted: TwinFaults | None = None) -> TwinFaults:
        """Inject faults into the twin's sensing; None only asks. Those in force; ParameterError on hardware."""
        return self._of_twin(TwinFaults, self._keys.faults, wanted)

    def time(self, wanted: TwinTime | None = None) -> TwinTime:
        """Let the twin's time stand still or go on; None only asks. As it is then; ParameterError on hardware."""
        return self._of_twin(TwinTime, self._keys.time, wanted)

    def drivers(self) -> Drivers:
        """How the rig's devices fare; none of a twin. RigUnreachable without an answer."""
        return Drivers.model_validate_json(self._asker.ask(self._keys.drivers).payload)

    def close(self) -> None:
        """End the connection; no callback comes after this. Another server may command the rig at once."""
        self._asker.leave(LEAVE_TIMEOUT)
        self._session.close()
        while self.worker.alive:
            self._queue.put(None)
            if self.worker.stop(0.1):
                return

    def _of_twin(self, kind: type[M], key: str, wanted: M | None) -> M:
        """Read what is in force at `key` with None, or put `wanted` in force, and what is then."""
        if wanted is None:
            return kind.model_validate_json(self._asker.ask(key).payload)
        return kind.model_validate_json(self._asker.ask_sealed(key, wanted.model_dump_json().encode()))

    def _on_batch(self, sample: Any) -> None:
        """In a thread of zenoh: only judge and queue; a full queue drops the batch, a replay brings it back."""
        now = time.monotonic()
        try:
            batch = self._heard_first(sample, now)
            if self._queue.qsize() < QUEUED_BATCHES:
                self._queue.put(batch)
        except Unproven as error:
            self._refusals.note(self._keys.telemetry, error)

    def _heard_first(self, sample: Any, now: float) -> _Batch:
        """A batch that bears the rig's proof, and was not sent before; raises Unproven."""
        attachment, payload = sample.attachment, sample.payload
        if attachment is None or len(attachment) > PROOF_BYTES:
            raise Unproven("refused: it bears no proof of the rig's key")
        found = payload.to_bytes()
        batch = _Batch(*read_batch(self._key, self._keys.telemetry, attachment.to_bytes(), found), now, found)
        with self._hearing:
            if batch.boot in self._dead or (batch.boot == self._boot and batch.number <= self._heard):
                raise Unproven(f"refused: batch {batch.number} of boot {batch.boot} was sent before")
            if batch.boot == self._boot:
                self._heard = batch.number
                if batch.number > self._floor:  # or it was overtaken by the answer, and says nothing of now
                    self._last, self._kept_out = batch.arrived, None
        return batch

    def _on_alive(self, sample: Any) -> None:
        change = self._alive.add if sample.kind == zenoh.SampleKind.PUT else self._alive.discard
        change(str(sample.key_expr).rpartition("/")[2])

    def _work(self) -> None:
        while True:
            self.worker.turn()
            try:
                batch = self._queue.get(timeout=LOOK_S)
            except queue.Empty:
                self._look()
                continue
            if batch is None:
                return
            try:
                self._take(batch)
            except RigUnreachable as error:
                log.info("%s", error)
            except Unproven as error:
                self._refusals.note(self._keys.telemetry, error)
            except Exception as error:
                self._complain(error)

    def _look(self) -> None:
        """Nothing comes: are we kept out?"""
        before, self._kept_out = self._kept_out, None if self._joined() else probe(self._endpoint)
        if self._kept_out and not before:
            log.warning("%s", self._kept_out)

    def _joined(self) -> bool:
        """Whether a session with the other end is open."""
        try:
            return bool(self._session.info.peers_zid() or self._session.info.routers_zid())
        except zenoh.ZError:  # closed meanwhile
            return True

    def _complain(self, error: Exception) -> None:
        """Log with the traceback once for every kind: there are 60 batches a second."""
        kind = type(error)
        log.error("telemetry batch failed: %s: %s", kind.__name__, error, exc_info=kind not in self._logged)
        self._logged.add(kind)

    def _take(self, batch: _Batch) -> None:
        if self._boot != batch.boot or not (self._pace or self._refused):
            self._meet(batch.boot, batch.number)
        if self._boot != batch.boot or self._pace is None or batch.number <= self._floor:
            return
        if len(batch.payload) % ROW.itemsize:
            raise Unproven(f"refused: {len(batch.payload)} bytes are not rows of {ROW.itemsize}")
        rows = np.frombuffer(batch.payload, ROW)
        self._paused = not len(rows)
        if self._paused:
            self._flows = True
            return
        try:
            self._pace.judge(rows, batch.arrived)
        except Unproven:
            self._pace = None  # the rig itself is asked, before anything else is taken
            raise
        self._flows = True
        self._stream.take(rows)

    def _meet(self, boot: int, number: int) -> None:
        """A new boot of the rig, of which batch `number` told: do we speak the same layout, who is it, and where do its
        rows begin?

        Its answer is proven to be of this moment, so batches sent before it, which others may have kept, are too old.
        One that the answer overtook comes after it: it is passed over, and no forgery.
        """
        asked = time.monotonic()
        payload, proof = self._asker.ask(self._keys.info)
        answer, now = json.loads(payload), time.monotonic()
        if proof.boot != boot:
            self._dead.append(boot)
            return
        if self._boot == boot and self._info:
            self._begin(proof, asked, self._info)
            return
        first_contact, self._refused, self._pace, self._flows = self._boot is None, None, None, False
        with self._hearing:
            self._boot, self._heard, self._floor, self._last = boot, number, proof.sent, now
        self._asker.forget()
        self._stopper.forget()
        with contextlib.suppress(TendrilError):  # an E-STOP opens it too, only later
            if self._commands:
                self._stopper.prepare()
        try:
            self._info = self._read(answer)
        except LayoutMismatch as error:
            self._refused = error
            log.error("%s", error)
            return
        self._begin(proof, asked, self._info)
        self._stream.expect(None if first_contact else 0)
        self._on_boot(self._info)

    def _begin(self, proof: Reply, asked: float, info: RigInfo) -> None:
        """Judge what comes by what the rig says of itself now."""
        self._floor = proof.sent
        self._pace = Pace(info.parameters.controller.dt, proof.clock_ns, asked)

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
            return np.empty(0, ROW)


def press(number: int, boot: int, by: str) -> bytes:
    """An E-STOP as it goes to the rig."""
    return np.array([boot, number], np.int64).tobytes() + by.encode(errors="replace")[:NAME_MAX_BYTES]
