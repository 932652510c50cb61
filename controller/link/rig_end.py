"""The rig's end of the link: it publishes telemetry and answers commands, replays and questions."""

import logging
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

import numpy as np
import zenoh
from pydantic import ValidationError

from controller.errors import ParameterError, TendrilError, sentence
from controller.layout import from_record, record_dtype
from controller.link.keys import Keys
from controller.messages import Command, CommandReply, RigInfo, TwinFaults

log = logging.getLogger(__name__)


class RigService(Protocol):
    """What the rig process does for the link; every method is called from a thread of zenoh."""

    def info(self) -> RigInfo:
        """Who the rig is."""

    def submit(self, command: Command) -> CommandReply:
        """Hand the command to the loop and wait until it has looked at it."""

    def replay(self, first: int, count: int) -> np.ndarray:
        """Telemetry rows of ticks [first, first + count) that are still there."""

    def plan(self, points: np.ndarray, again: int, ticks: int) -> int:
        """Take (n, 2) points [m] as the planned reference, to follow as `RigClient.plan` says; their number."""

    def faults(self, wanted: TwinFaults | None) -> TwinFaults:
        """Inject faults into the twin's sensing, None changes nothing; those in force."""


class RigEnd:
    """Declares the keys of one rig on `session`; `close` withdraws them, the session stays its owner's."""

    def __init__(self, session: Any, rig: str, boot: int, service: RigService) -> None:
        """Start to answer; the liveliness token comes last, when everything else works."""
        self._keys = Keys(rig)
        self._boot = boot.to_bytes(8, "little")
        self._service = service
        self._publisher = session.declare_publisher(
            self._keys.telemetry, congestion_control=zenoh.CongestionControl.DROP, express=True
        )
        answers: dict[str, Callable[[bytes], bytes]] = {
            self._keys.command: self._command,
            self._keys.replay: self._replay,
            self._keys.reference: self._reference,
            self._keys.faults: self._faults,
            self._keys.info: lambda payload: service.info().model_dump_json().encode(),
        }
        self._declared = [
            session.declare_queryable(key, partial(_answer, key, answer)) for key, answer in answers.items()
        ]
        self._declared.append(session.liveliness().declare_token(self._keys.alive(str(boot))))

    def publish(self, rows: np.ndarray) -> None:
        """Send Telemetry rows as one batch; a reader that cannot keep up misses it and asks for a replay."""
        self._publisher.put(rows.tobytes(), attachment=self._boot)

    def close(self) -> None:
        """Withdraw the token first, then the rest."""
        for declared in [*reversed(self._declared), self._publisher]:
            declared.undeclare()

    def _command(self, payload: bytes) -> bytes:
        return self._service.submit(read_command(payload)).model_dump_json().encode()

    def _replay(self, payload: bytes) -> bytes:
        if len(payload) != 16:
            raise ParameterError(f"replay request of {len(payload)} bytes is not two int64 words (first tick, count)")
        first, count = np.frombuffer(payload, np.int64).tolist()
        return self._service.replay(first, count).tobytes()

    def _reference(self, payload: bytes) -> bytes:
        if len(payload) < 16 or len(payload) % 16:
            raise ParameterError(f"reference of {len(payload)} bytes is not two int64 words and rows of two float64")
        again, ticks = np.frombuffer(payload[:16], np.int64).tolist()
        points = np.frombuffer(payload, offset=16).reshape(-1, 2)
        return self._service.plan(points, again, ticks).to_bytes(8, "little")

    def _faults(self, payload: bytes) -> bytes:
        try:
            wanted = TwinFaults.model_validate_json(payload) if payload else None
        except ValidationError as error:
            raise ParameterError(sentence(error)) from error
        return self._service.faults(wanted).model_dump_json().encode()


def read_command(payload: bytes) -> Command:
    """The Command in `payload`; raises ParameterError naming what is wrong: size, or field, value and bound."""
    dtype = record_dtype(Command)
    if len(payload) != dtype.itemsize:
        raise ParameterError(f"command of {len(payload)} bytes is not a Command record of {dtype.itemsize} bytes")
    try:
        return from_record(Command, np.frombuffer(payload, dtype)[0])
    except ValidationError as error:
        raise ParameterError("; ".join(_sentence(item) for item in error.errors())) from error


def _sentence(item: Any) -> str:
    """One pydantic error as "settings.K_P.0 = 12.0: Input should be less than or equal to 5"."""
    return f"{'.'.join(map(str, item['loc']))} = {item['input']}: {item['msg']}"


def _answer(key: str, answer: Callable[[bytes], bytes], query: Any) -> None:
    """Reply to one query; every error becomes an error reply, so that a caller never waits in vain."""
    with query:
        try:
            query.reply(key, answer(query.payload.to_bytes() if query.payload else b""))
        except TendrilError as error:
            query.reply_err(str(error))
        except Exception:
            log.exception("query on %s failed", key)
            query.reply_err(f"the rig could not answer on {key}")
