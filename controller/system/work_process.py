"""A process of its own that works for this one, kept from one piece of work to the next.

What is called there is imported there: compilers, kernels and tables stay out of our memory, and what takes seconds
stays out of the way of our event loop. The work must be a function of a module, its arguments and result picklable. It
may be done twice: a process that is killed is started again, and asked once more, unless it alone can answer.
"""

import asyncio
import itertools
import os
import pickle
import signal
import socket
import struct
import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from controller.errors import ProcessKilled
from controller.system.child import launched

P = ParamSpec("P")
T = TypeVar("T")
PATIENCE = 120.0
"""Longest wait for an answer before the process is taken to hang [s]."""
SENDING = 10.0
"""The same for it to take in what it is asked [s]."""
TRIES = 2
NUMBER = struct.Struct("q")
"""Of a question, before it and before its answer."""


class WorkProcess:
    """Thread safe. The process starts when it is first asked; it and all that it runs end when this one does."""

    def __init__(self, name: str, patience: float | None = PATIENCE, nice: int = 0, tries: int = TRIES) -> None:
        """`name` says what it is for, in errors and in the list of processes; `patience` None: work may take hours."""
        self._name, self._patience, self._nice, self._tries = name, patience, nice, tries
        self._life: _Life | None = None
        self._closed = False
        self._starting = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Of the process, while there is one."""
        life = self._life
        return life.process.pid if life is not None and life.alive else None

    async def do(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work(*arguments, **named)` there: its result, or its error; ProcessKilled where it was killed twice."""
        return await asyncio.to_thread(lambda: self.call(work, *arguments, **named))

    def call(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """The same for a thread that may wait."""
        asked = pickle.dumps((work, arguments, named))
        for _ in range(self._tries):
            life = self._living()
            try:
                answer = life.ask(asked)
                if not wait([answer], self._patience).done:
                    life.end()
                    raise ProcessKilled(f"{self._name} took more than {self._patience:g} s; it was ended")
                found: T = answer.result()
            except _Gone:
                continue
            return found
        twice = " twice" * (self._tries > 1)
        raise ProcessKilled(f"{self._name}: its process was killed{twice}, perhaps for want of memory")

    def close(self) -> None:
        """End the process, if there is one, and start none again; who waits for it hears of that."""
        with self._starting:
            self._closed = True
            if self._life is not None:
                self._life.end()

    def _living(self) -> "_Life":
        with self._starting:
            if self._closed:
                raise ProcessKilled(f"{self._name} has ended")
            if self._life is None or not self._life.alive:
                self._life = _Life(self._name, self._nice)
            return self._life


class _Gone(Exception):
    """The process ended before it answered."""


class _Life:
    """One process, and what it was asked and has not answered."""

    def __init__(self, name: str, nice: int) -> None:
        ours, theirs = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(SENDING), 0))
        with theirs:
            end = theirs.fileno()
            self.process = launched(("controller.system.working", str(end), str(nice), name), None, keep=(end,))
        self._pipe = Connection(ours.detach())
        self._asked: dict[int, Future[Any]] = {}
        self._numbers = itertools.count()
        self._sending, self._lock = threading.Lock(), threading.Lock()
        self._open = True
        threading.Thread(target=self._read, name=name, daemon=True).start()

    @property
    def alive(self) -> bool:
        return self._open and self.process.poll() is None

    def ask(self, asked: bytes) -> "Future[Any]":
        """What comes of it, once; raises _Gone where it cannot be asked."""
        answer: Future[Any] = Future()
        with self._lock:
            number = next(self._numbers)
            if not self._open:
                raise _Gone
            self._asked[number] = answer
        try:
            with self._sending:
                self._pipe.send_bytes(NUMBER.pack(number) + asked)
        except OSError:  # it ended, or takes nothing in
            self.end()
        return answer

    def end(self) -> None:
        """Kill it and what it runs; the reader then tells who waits."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)

    def _read(self) -> None:
        """Hand out the answers until the process ends."""
        try:
            while True:
                message = self._pipe.recv_bytes()
                with self._lock:
                    answer = self._asked.pop(NUMBER.unpack_from(message)[0])
                _give(answer, message[NUMBER.size :])
        except (EOFError, OSError):
            pass
        finally:
            self._close()

    def _close(self) -> None:
        with self._lock:
            self._open, waiting = False, list(self._asked.values())
        self.end()
        self.process.wait()
        with self._sending:
            self._pipe.close()
        for answer in waiting:
            answer.set_exception(_Gone())


def _give(answer: "Future[Any]", message: bytes) -> None:
    try:
        result, error = pickle.loads(message)
    except Exception as unfit:
        result, error = None, unfit
    if error is None:
        answer.set_result(result)
    else:
        answer.set_exception(error)
