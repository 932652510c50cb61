"""Errors at the command line: one line that names what is wrong, never a traceback for a user's mistake."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pydantic import ValidationError
from rich.console import Console
from rich.markup import escape

from controller.errors import TendrilError, sentence
from controller.logs import logs_json

log = logging.getLogger(__name__)


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Print (or log, as JSON) our own errors and refused values in one line and end with code 1."""
    try:
        yield
    except ValidationError as error:
        _end(sentence(error))
    except TendrilError as error:
        _end(str(error))


def _end(text: str) -> None:
    if logs_json():
        log.critical("%s", text)
        sys.exit(1)
    Console(stderr=True, soft_wrap=True).print(f"[red]tendril:[/] {escape(text)}", highlight=False)
    sys.exit(1)
