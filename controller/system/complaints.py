"""Errors at the command line: one line that names what is wrong, never a traceback for a user's mistake."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pydantic import ValidationError
from rich.console import Console
from rich.markup import escape

from controller.errors import StartRefused, TendrilError, sentence
from controller.system.logs import logs_json

log = logging.getLogger(__name__)


@contextmanager
def one_line_errors(code: int = 1) -> Iterator[None]:
    """Print (or log, as JSON) our own errors and refused values in one line and end with `code`."""
    try:
        yield
    except StartRefused:  # it was said already
        sys.exit(code)
    except ValidationError as error:
        _say(sentence(error))
        sys.exit(code)
    except TendrilError as error:
        _say(str(error))
        sys.exit(code)


def _say(text: str) -> None:
    if logs_json():
        return log.critical("%s", text)
    Console(stderr=True, soft_wrap=True).print(f"[red]tendril:[/] {escape(text)}", highlight=False)
