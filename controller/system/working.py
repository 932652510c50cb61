"""The other end of a WorkProcess: `python -m controller.system.working FD NICE NAME` answers what comes on that socket.

NAME is for who looks at the list of processes.
"""

import os
import pickle
import signal
import sys
import threading
import traceback
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any

from controller.errors import TendrilError
from controller.system.memory import few_arenas, give_back
from controller.system.work_process import NUMBER

WORKERS = 4
"""Pieces of work at once; one that is long does not keep the others."""


class Working:
    """Answers on `pipe` until no one is left who asks."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._sending = threading.Lock()
        self._threads = ThreadPoolExecutor(WORKERS, "work")

    def run(self) -> None:
        """Read until the other end is closed."""
        while True:
            try:
                message = self._pipe.recv_bytes()
            except (EOFError, OSError):
                return
            self._threads.submit(self._answer, message)

    def _answer(self, message: bytes) -> None:
        answer = _packed(*_done(message[NUMBER.size :]))
        with self._sending:
            self._pipe.send_bytes(message[: NUMBER.size] + answer)
        give_back()


def _done(asked: bytes) -> tuple[Any, Exception | None]:
    """Result and error of the work that was asked for."""
    try:
        work, arguments, named = pickle.loads(asked)
        return work(*arguments, **named), None
    except TendrilError as error:
        return None, error
    except Exception as error:  # the one who asked hears where it was
        error.add_note(traceback.format_exc())
        return None, error


def _packed(result: Any, error: Exception | None) -> bytes:
    try:
        return pickle.dumps((result, error))
    except Exception as unfit:
        return pickle.dumps((None, RuntimeError(f"the answer cannot be sent: {unfit}; {error!r}")))


if __name__ == "__main__":
    few_arenas()
    os.nice(max(0, int(sys.argv[2]) - os.nice(0)))  # ours is that of who asks, who may go before others
    Working(Connection(int(sys.argv[1]))).run()
    os.killpg(0, signal.SIGKILL)  # us and what we run, whatever is still being worked at: no one waits for it
