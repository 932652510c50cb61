"""Exports in a process of their own, at low priority: the server goes on serving, and its memory stays as it is."""

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import ParamSpec, TypeVar

from controller.errors import TendrilError

P = ParamSpec("P")
T = TypeVar("T")
NICE = 19


class ExportKilled(TendrilError):
    """The process of an export was killed from outside."""


def apart(work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """`work(*arguments, **named)` elsewhere: its result or its error; ExportKilled when it was killed."""
    with ProcessPoolExecutor(1, get_context("spawn"), initializer=os.nice, initargs=(NICE,)) as pool:
        try:
            return pool.submit(work, *arguments, **named).result()
        except BrokenProcessPool:
            raise ExportKilled("the export was killed, perhaps for want of memory: choose fewer signals") from None
