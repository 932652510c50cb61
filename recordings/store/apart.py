"""Work in a process of its own, at low priority: the server goes on serving, and its memory stays as it is."""

import os
import signal
import sys
from collections.abc import Callable, Mapping
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from controller.errors import ProcessKilled
from controller.system.parent import end_with_parent

P = ParamSpec("P")
T = TypeVar("T")
NICE = 19


def apart(work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """`work(*arguments, **named)` elsewhere: its result or its error; ProcessKilled when it was killed.

    It ends when we do.
    """
    context = get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(theirs, NICE, work, arguments, named), daemon=True)
    process.start()
    theirs.close()
    try:
        result, error = ours.recv()
    except EOFError:
        raise ProcessKilled("the process was killed, perhaps for want of memory") from None
    finally:
        process.join()
        ours.close()
    if error is not None:
        raise error
    found: T = result
    return found


def _answer(
    to: Connection, nice: int, work: Callable[..., Any], arguments: tuple[Any, ...], named: Mapping[str, Any]
) -> None:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())  # so that a program that we run is ended too
    end_with_parent()
    os.nice(nice)
    try:
        result = work(*arguments, **named)
    except Exception as error:
        to.send((None, error))
    else:
        to.send((result, None))
