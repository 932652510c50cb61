"""Waiting for what must come, and what a fault that failed says."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

from controller.errors import TendrilError

T = TypeVar("T")


class Failed(TendrilError):
    """Something expected did not happen, or something else did."""


class NotTried(Failed):
    """What a fault needs did not come about, so nothing is known of the fault."""


class Skipped(TendrilError):
    """A fault that cannot be injected here."""


class Seen(NamedTuple):
    """What came of a fault."""

    observed: str
    reaction_ms: float


def wait(what: Callable[[], T | None], seconds: float, text: str, pause: float = 0.01) -> T:
    """The first true value of `what()`; `Failed` after `seconds`, and never without a look that began after them."""
    end = time.monotonic() + seconds
    over = False
    while not (found := what()):
        if over:
            raise Failed(f"not within {seconds:g} s: {text}")
        time.sleep(pause)
        over = time.monotonic() > end
    return found


@contextmanager
def before_the_fault() -> Iterator[None]:
    """What fails in here is `NotTried`."""
    try:
        yield
    except Failed as error:
        raise NotTried(str(error)) from error


def require(condition: object, text: str) -> None:
    """Raise `Failed` with `text` unless `condition` holds."""
    if not condition:
        raise Failed(text)
