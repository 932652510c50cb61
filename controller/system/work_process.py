"""A child process that works for this one, kept from one piece of work to the next.

What is called there is imported there: compilers, kernels and tables stay out of our memory, and what takes seconds
stays out of the way of our event loop. The work must be a function of a module, its arguments and result picklable. It
may be done twice: a process that is killed is started again, and asked once more, unless it alone can answer.
"""

import asyncio
import itertools
import pickle
import socket
import struct
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from controller.errors import ProcessKilled
from controller.system.child import ChildProcess, kill_session, launched
from controller.system.thread import SupervisedThread

P = ParamSpec("P")
T = TypeVar("T")
ANSWER_S = 120.0
"""Longest wait for an answer before the process is taken to hang."""
SENDING_S = 10.0
"""The same for it to take in what it is asked."""
ATTEMPTS_MAX = 2
NICE = 10
"""At least: work gives way to the process that asks for it: that answers an E-STOP meanwhile."""
NUMBER = struct.Struct("q")
"""Of a question, before it and before its answer."""


class WorkProcess:
    """Thread safe. The process starts when it is first asked; it and all that it runs end when this one does."""

    def __init__(
        self, name: str, patience: float | None = ANSWER_S, nice: int = NICE, tries: int = ATTEMPTS_MAX
    ) -> None:
        """`name` says what it is for, in errors and in the list of processes; `patience` None: work may take hours."""
        self._name, self._patience, self._nice, self._tries = name, patience, nice, tries
        self._child = ChildProcess(name, self._launch)
        self._line: _Line | None = None
        self._stopped = False
        self._starting = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Of the process, while there is one."""
        process = self._child.process
        return process.pid if process is not None and self._child.alive else None

    @property
    def trouble(self) -> str:
        """What is wrong with it, "" when it is well: it starts when it is asked."""
        return "" if self._line is None or self._stopped else self._child.trouble

    def start(self) -> None:
        """Start it before it is asked."""
        self._open_line()

    async def do(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work(*arguments, **named)` there: its result, or its error; ProcessKilled where it was killed twice."""
        return await asyncio.to_thread(lambda: self.call(work, *arguments, **named))

    def call(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """The same for a thread that may wait."""
        asked = pickle.dumps((work, arguments, named))
        for _ in range(self._tries):
            line = self._open_line()
            try:
                answer = line.ask(asked)
                if not wait([answer], self._patience).done:
                    line.end()
                    raise ProcessKilled(f"{self._name} took more than {self._patience:g} s; it was ended")
                found: T = answer.result()
            except _Gone:
                continue
            return found
        twice = " twice" * (self._tries > 1)
        raise ProcessKilled(f"{self._name}: its process was killed{twice}, perhaps for want of memory")

    def stop(self, timeout: float = 0.0) -> bool:
        """End the process at once, if there is one, and start none again; who waits for it hears of that."""
        with self._starting:
            self._stopped = True
            if self._line is not None:
                self._line.end()
        return True

    def _open_line(self) -> "_Line":
        with self._starting:
            if self._stopped:
                raise ProcessKilled(f"{self._name} has ended")
            if self._line is None or not self._line.is_open or not self._child.alive:
                self._child.start()
            assert self._line is not None
            return self._line

    def _launch(self) -> "subprocess.Popen[bytes]":
        ours, theirs = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(SENDING_S), 0))
        with theirs:
            end = theirs.fileno()
            process = launched(("controller.system.working", str(end), str(self._nice), self._name), None, keep=(end,))
        self._line = _Line(self._name, process, Connection(ours.detach()))
        return process


class _Gone(Exception):
    """The process ended before it answered."""


class _Line:
    """To one process: what it was asked and has not answered."""

    def __init__(self, name: str, process: "subprocess.Popen[bytes]", pipe: Connection) -> None:
        self._process, self._pipe = process, pipe
        self._asked: dict[int, Future[Any]] = {}
        self._numbers = itertools.count()
        self._sending, self._lock = threading.Lock(), threading.Lock()
        self.is_open = True
        SupervisedThread(name, self._read).start()

    def ask(self, asked: bytes) -> "Future[Any]":
        """What comes of it, once; raises _Gone where it cannot be asked."""
        answer: Future[Any] = Future()
        with self._lock:
            number = next(self._numbers)
            if not self.is_open:
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
        kill_session(self._process)

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
            self.is_open, waiting = False, list(self._asked.values())
        self.end()
        self._process.wait()
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
