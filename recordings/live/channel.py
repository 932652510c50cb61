"""The socket on which the recorder's process is asked, by servers on its machine that have the rig's key.

Its name, in Linux's abstract space, is a digest of what is recorded where, and of the key. So it is there for as long
as its process is, only one can have it, and every server finds the recorder that writes for its rig into its folder.
Both ends prove that they have the key before anything is read: messages are pickled.
"""

import hmac
import os
import socket
import struct
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, answer_challenge, deliver_challenge
from pathlib import Path
from typing import Any, NamedTuple

from controller.link.version import LAYOUT, OURS
from recordings.format.messages import Recording, RecordingState

PROOF_TIMEOUT_S, SEND_TIMEOUT_S = 5, 5
"""Longest wait for the other end: to prove itself, and to take a message in."""


@dataclass(frozen=True)
class RecorderSettings:
    """What a recorder is to record, and how."""

    rig: str
    endpoint: str
    folder: Path
    split: int
    """Bytes at which a recording goes on in another file."""
    patience: float
    """A disk that takes nothing for so long ends the recording [s]."""
    tls: Path | None = None
    key: bytes = field(repr=False, default=b"")

    @property
    def address(self) -> str:
        """Of the socket. A server of another version has another one: it would not understand the answers."""
        said = f"{self} {self.folder.absolute()} {OURS} {LAYOUT}"
        return f"\0tendril-recorder-{hmac.digest(self.key, said.encode(), 'sha256').hex()[:32]}"


class Seen(NamedTuple):
    """The newest row that who asks has seen: what is asked is done once the recorder has it, too."""

    boot: int
    tick: int


class Question(NamedTuple):
    """`name` is a method of the recorder's host; `number` None: no answer is waited for."""

    number: int | None
    name: str
    arguments: tuple[Any, ...]


class News(NamedTuple):
    """How the recorder is."""

    state: RecordingState
    running: Recording | None
    """The recording that goes on, as it was described when it began."""
    trouble: str
    """What is wrong with its thread, "" if nothing is."""
    pid: int


class Message(NamedTuple):
    """From the recorder: news, and the answer to a question or the end of a recording where there is one."""

    news: News
    number: int | None = None
    result: Any = None
    error: Exception | None = None
    ended: Recording | None = None
    """A recording that ended without being waited for, and is whole."""
    left: bool = False
    """The first message: the recording that goes on was left by a killed server."""


def listening(settings: RecorderSettings) -> socket.socket:
    """The recorder's end; OSError where another recorder has it."""
    found = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        found.bind(settings.address)
        found.listen()
    except OSError:
        found.close()
        raise
    return found


def accepted(theirs: socket.socket, key: bytes) -> Connection:
    """The connection with a server; an OSError, EOFError or AuthenticationError of one that does not prove itself."""
    connection = _timed(theirs)
    deliver_challenge(connection, key)
    answer_challenge(connection, key)
    return _proven(connection)


def connected(settings: RecorderSettings) -> Connection:
    """The connection with the recorder; errors as above, and where there is none."""
    ours = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        ours.connect(settings.address)
    except OSError:
        ours.close()
        raise
    connection = _timed(ours)
    answer_challenge(connection, settings.key)
    deliver_challenge(connection, settings.key)
    return _proven(connection)


def hang_up(connection: Connection) -> None:
    """End it from any thread; who reads or writes there hears of that, and closes it."""
    with suppress(OSError), socket.socket(fileno=os.dup(connection.fileno())) as end:
        end.shutdown(socket.SHUT_RDWR)


def _timed(end: socket.socket) -> Connection:
    end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", SEND_TIMEOUT_S, 0))
    end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", PROOF_TIMEOUT_S, 0))
    return Connection(end.detach())


def _proven(connection: Connection) -> Connection:
    with socket.socket(fileno=os.dup(connection.fileno())) as end:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", 0, 0))
    return connection
