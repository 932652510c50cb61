"""Exports in a process of their own."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from controller.errors import ProcessKilled, TendrilError
from recordings.store import apart as process

P = ParamSpec("P")
T = TypeVar("T")


class ExportKilled(TendrilError):
    """The process of an export was killed from outside."""


def apart(work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """`recordings.store.apart.apart`; ExportKilled when it was killed."""
    try:
        return process.apart(work, *arguments, **named)
    except ProcessKilled:
        raise ExportKilled("the export was killed, perhaps for want of memory: choose fewer signals") from None
