"""The rig's end of the link: it publishes telemetry and answers commands, replays and questions.

What changes the rig is judged in this order: size, seal, meaning, and who holds the rig. What it says bears a proof.
"""

import logging
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np
import zenoh
from pydantic import ValidationError

from controller.errors import ParameterError, TendrilError, sentence
from controller.link.keys import NAME_MAX_BYTES, REPLAY_MAX, Keys
from controller.link.planned import PLANNED_MAX, PlannedRows, decoded
from controller.link.proof import Prover, question
from controller.link.refusals import Refusals
from controller.link.seal import SEAL_BYTES, Holder, SealedSession, Seals
from controller.schema.hardware import Drivers
from controller.schema.layout import from_record, record_dtype
from controller.schema.messages import Command, CommandReply, RigInfo, TwinFaults, TwinTime
from controller.schema.modes import Request

log = logging.getLogger(__name__)

JSON_MAX = 1024
"""Longest JSON text that is parsed [bytes]."""

Answer = Callable[[bytes, bytes], bytes]
"""From payload and seal to the reply."""
M = TypeVar("M", TwinFaults, TwinTime)


class RigService(Protocol):
    """What the rig process does for the link; every method is called from a thread of zenoh."""

    def info(self) -> RigInfo:
        """Who the rig is."""

    def submit(self, command: Command) -> CommandReply:
        """Hand the command to the loop and wait until it has looked at it."""

    def stop(self, who: tuple[int, int], boot: int | None = None, by: str = "") -> CommandReply:
        """E-STOP at once, pressed by the person `by`; `who` is the same where it is only repeated. Refused if meant for
        another `boot`.
        """

    def replay(self, first: int, count: int) -> np.ndarray:
        """Telemetry rows of ticks [first, first + count) that are still there."""

    def plan(self, rows: PlannedRows) -> int:
        """Take `rows` as the planned reference of the next TRACK run; their number."""

    def faults(self, wanted: TwinFaults | None) -> TwinFaults:
        """Inject faults into the twin's sensing, None changes nothing; those in force."""

    def drivers(self) -> Drivers:
        """How the rig's devices fare."""

    def time(self, wanted: TwinTime | None) -> TwinTime:
        """Let the twin's time stand still or go on, None changes nothing; as it is now."""


class RigEnd:
    """Declares the keys of one rig on `session`; `close` withdraws them, the session stays its owner's."""

    def __init__(self, session: Any, rig: str, seals: Seals, service: RigService) -> None:
        """Start to answer; the liveliness token comes last, when everything else works."""
        self.refusals = Refusals(rig)
        self._keys = Keys(rig)
        self._seals, self._prover, self._holder = seals, seals.prover, Holder()
        self._zenoh = session
        self._boot = seals.boot.to_bytes(8, "little")
        self._service = service
        self._publisher = session.declare_publisher(
            self._keys.telemetry, congestion_control=zenoh.CongestionControl.DROP, express=True
        )
        answers: dict[str, tuple[int, Answer]] = {
            self._keys.command: (record_dtype(Command).itemsize, self._command),
            self._keys.stop: (16 + NAME_MAX_BYTES, self._stop),
            self._keys.replay: (16, self._replay),
            self._keys.reference: (PLANNED_MAX, self._reference),
            self._keys.faults: (JSON_MAX, partial(self._twin, self._keys.faults, TwinFaults, service.faults)),
            self._keys.time: (JSON_MAX, partial(self._twin, self._keys.time, TwinTime, service.time)),
            self._keys.drivers: (0, lambda payload, seal: service.drivers().model_dump_json().encode()),
            self._keys.info: (0, lambda payload, seal: service.info().model_dump_json().encode()),
            self._keys.session: (JSON_MAX, self._session),
            self._keys.leave: (0, self._leave),
        }
        self._declared = [
            session.declare_queryable(key, partial(_answer, self.refusals, self._prover, key, most, answer))
            for key, (most, answer) in answers.items()
        ]
        self._declared.append(session.liveliness().declare_token(self._keys.alive(str(seals.boot))))

    def publish(self, rows: np.ndarray) -> None:
        """Send Telemetry rows as one batch; a reader that cannot keep up misses it and asks for a replay.

        A batch without rows says that the rig is there and its time stands still.
        """
        payload = rows.tobytes()
        self._publisher.put(payload, attachment=self._prover.batch(self._keys.telemetry, payload))

    def publish_last(self, rows: np.ndarray) -> None:
        """Send the last ones: there will be no one to ask for a replay, so they wait where the link is full."""
        payload = rows.tobytes()
        seal = self._prover.batch(self._keys.telemetry, payload)
        block = zenoh.CongestionControl.BLOCK
        self._zenoh.put(self._keys.telemetry, payload, attachment=seal, congestion_control=block, express=True)

    def close(self) -> None:
        """Withdraw the token first, then the rest."""
        for declared in [*reversed(self._declared), self._publisher]:
            declared.undeclare()

    def _session(self, payload: bytes, seal: bytes) -> bytes:
        if not payload:
            return self._boot + self._seals.next_session.to_bytes(8, "little")
        opened = self._seals.open(self._keys.session, payload, seal)
        log.info("session opened by %s", opened.who)
        return b""

    def _leave(self, payload: bytes, seal: bytes) -> bytes:
        self._holder.leave(self._seals.admit(self._keys.leave, payload, seal))
        return b""

    def _command(self, payload: bytes, seal: bytes) -> bytes:
        _require_record(payload)
        session = self._seals.admit(self._keys.command, payload, seal)
        return self._obey(session, read_command(payload)).model_dump_json().encode()

    def _obey(self, session: SealedSession, command: Command) -> CommandReply:
        if command.request == Request.E_STOP:
            return self._service.stop((session.number, command.n))
        self._holder.take(session)
        return self._service.submit(command)

    def _stop(self, payload: bytes, seal: bytes) -> bytes:
        if len(payload) < 16:
            raise ParameterError(f"E-STOP of {len(payload)} bytes is not two int64 words (boot, its number) and a name")
        self._seals.admit(self._keys.stop, payload, seal)
        boot, number = np.frombuffer(payload[:16], np.int64).tolist()
        by = payload[16:].decode(errors="replace")  # an E-STOP is refused for no name
        return self._service.stop((0, number), boot, by).model_dump_json().encode()

    def _replay(self, payload: bytes, seal: bytes) -> bytes:
        if len(payload) != 16:
            raise ParameterError(f"replay request of {len(payload)} bytes is not two int64 words (first tick, count)")
        first, count = np.frombuffer(payload, np.int64).tolist()
        if first < 0:
            raise ParameterError(f"replay: first = {first} is below 0")
        if not 1 <= count <= REPLAY_MAX:
            raise ParameterError(f"replay: count = {count} is outside [1, {REPLAY_MAX}]")
        return self._service.replay(first, count).tobytes()

    def _reference(self, payload: bytes, seal: bytes) -> bytes:
        rows = decoded(payload)
        self._holder.take(self._seals.admit(self._keys.reference, payload, seal))
        return self._service.plan(rows).to_bytes(8, "little")

    def _twin(self, key: str, kind: type[M], act: Callable[[M | None], M], payload: bytes, seal: bytes) -> bytes:
        """What is done to the twin: read with nothing, put in force with a sealed message of `kind`."""
        wanted = None
        if payload:
            session = self._seals.admit(key, payload, seal)
            try:
                wanted = kind.model_validate_json(payload)
            except ValidationError as error:
                raise ParameterError(sentence(error)) from error
            self._holder.take(session)
        return act(wanted).model_dump_json().encode()


def read_command(payload: bytes) -> Command:
    """The Command in `payload`; raises ParameterError naming what is wrong: size, or field, value and bound."""
    _require_record(payload)
    try:
        return from_record(Command, np.frombuffer(payload, record_dtype(Command))[0])
    except ValidationError as error:
        raise ParameterError("; ".join(_sentence(item) for item in error.errors())) from error


def _require_record(payload: bytes) -> None:
    size = record_dtype(Command).itemsize
    if len(payload) != size:
        raise ParameterError(f"command of {len(payload)} bytes is not a Command record of {size} bytes")


def _sentence(item: Any) -> str:
    """One pydantic error as "settings.K_P.0 = 12.0: Input should be less than or equal to 5"."""
    return f"{'.'.join(map(str, item['loc']))} = {item['input']}: {item['msg']}"


def _answer(refusals: Refusals, prover: Prover, key: str, most: int, answer: Answer, query: Any) -> None:
    """Reply to one query; every error becomes a reply of its kind, so that a caller never waits in vain."""
    with query:
        asked, kind = b"", ""
        try:
            payload, seal = _bounded(query.payload, "payload", most), _bounded(query.attachment, "seal")
            asked = question(seal, payload)
            found = answer(payload, seal)
        except TendrilError as error:
            refusals.note(key, error)
            found, kind = str(error).encode(), type(error).__name__
        except Exception as error:
            if refusals.note(key, error):
                log.exception("query on %s failed", key)
            found, kind = f"the rig could not answer on {key}".encode(), TendrilError.__name__
        query.reply(key, found, attachment=prover.reply(key, asked, found, kind))


def _bounded(given: Any, name: str, most: int = SEAL_BYTES) -> bytes:
    """The bytes of an optional ZBytes, which are looked at only where there are not too many."""
    if given is None:
        return b""
    if len(given) > most:
        raise ParameterError(f"{name} of {len(given)} bytes is above the limit of {most}")
    return bytes(given.to_bytes())
