"""The proof: that a batch or a reply comes from the rig that has our key, in the boot that it names, and comes once.

The seal's counterpart in the other direction, and like it an attachment, little endian:

    of a batch    int64 boot id | int64 number of the batch | 32 bytes HMAC-SHA256
    of a reply    int64 boot id | int64 batches sent so far | int64 the rig's clock [ns] | 32 bytes HMAC-SHA256 | kind

    HMAC-SHA256 over: b"tendril batch 1", the fields before it, key expression, zero byte, payload
                      b"tendril reply 1", the fields before it, kind, zero byte, key expression, zero byte,
                      SHA-256 of the question, payload

- The number of a batch rises strictly within a boot of the rig: none is taken twice, or after a later one.
- A reply is bound to the question, seal and payload, and every question holds something that was in none before: a
  random number, or a seal. An old reply answers nothing, and a reply to another question neither.
- `kind` names the error that a refusal is; it is empty where the payload is what was asked for.
"""

import hashlib
import hmac
import struct
import time
from typing import NamedTuple

from controller.errors import Unproven

_BATCH, _REPLY = struct.Struct("<qq"), struct.Struct("<qqq")
_MAC_BYTES = 32
PROOF_BYTES = _REPLY.size + _MAC_BYTES + 40
"""Most that an attachment may be long; kinds of errors are no longer than 40 letters."""


class Batch(NamedTuple):
    """What the proof of a batch says."""

    boot: int
    number: int


class Reply(NamedTuple):
    """What the proof of a reply says."""

    boot: int
    sent: int
    """Number of the last batch before it."""
    clock_ns: int
    kind: str


class Prover:
    """The rig's side, in one boot of it. Batches are proven by one thread, replies by any."""

    def __init__(self, key: bytes, boot: int) -> None:
        self._key, self._boot, self._sent = key, boot, 0

    def batch(self, expression: str, payload: bytes) -> bytes:
        """The attachment of the next batch."""
        self._sent += 1
        head = _BATCH.pack(self._boot, self._sent)
        return head + _batch_mac(self._key, head, expression, payload)

    def reply(self, expression: str, question: bytes, payload: bytes, kind: str = "") -> bytes:
        """The attachment of the reply to `question` (see `question`)."""
        head, name = _REPLY.pack(self._boot, self._sent, time.monotonic_ns()), kind.encode()[:40]
        return head + _reply_mac(self._key, head + name, expression, question, payload) + name


def question(attachment: bytes, payload: bytes) -> bytes:
    """All of a question, to which its reply is bound."""
    return hashlib.sha256(b"".join((len(attachment).to_bytes(8, "little"), attachment, payload))).digest()


def read_batch(key: bytes, expression: str, attachment: bytes, payload: bytes) -> Batch:
    """What the batch says of itself; Unproven unless it was made with `key`."""
    if len(attachment) != _BATCH.size + _MAC_BYTES:
        raise Unproven(f"refused: a proof of {len(attachment)} bytes is not one of {_BATCH.size + _MAC_BYTES}")
    head, mac = attachment[: _BATCH.size], attachment[_BATCH.size :]
    _require(mac, _batch_mac(key, head, expression, payload))
    return Batch(*_BATCH.unpack(head))


def read_reply(key: bytes, expression: str, question: bytes, attachment: bytes, payload: bytes) -> Reply:
    """What the reply to `question` says of itself; Unproven unless it was made with `key`, for this question."""
    end = _REPLY.size + _MAC_BYTES
    if not end <= len(attachment) <= PROOF_BYTES:
        raise Unproven(f"refused: a proof of {len(attachment)} bytes is not one of {end} to {PROOF_BYTES}")
    head, mac, name = attachment[: _REPLY.size], attachment[_REPLY.size : end], attachment[end:]
    _require(mac, _reply_mac(key, head + name, expression, question, payload))
    boot, sent, clock_ns = _REPLY.unpack(head)
    return Reply(boot, sent, clock_ns, name.decode())


def _require(found: bytes, wanted: bytes) -> None:
    if not hmac.compare_digest(found, wanted):
        raise Unproven("refused: it was not made with the rig's key, or not for this")


def _batch_mac(key: bytes, head: bytes, expression: str, payload: bytes) -> bytes:
    return _mac(key, b"tendril batch 1", head, expression.encode(), b"\0", payload)


def _reply_mac(key: bytes, head: bytes, expression: str, question: bytes, payload: bytes) -> bytes:
    return _mac(key, b"tendril reply 1", head, b"\0", expression.encode(), b"\0", question, payload)


def _mac(key: bytes, *message: bytes) -> bytes:
    return hmac.digest(key, b"".join(message), "sha256")
