"""Errors of our own, from one base, each carrying the value and the bound it broke."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic import Field as Bounds
from pydantic import ValidationError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_WORDS: dict[str, str] = {}


class TendrilError(Exception):
    """Base of every error that Tendril raises on purpose; its text is fit for a user."""


class ParameterError(TendrilError, ValueError):
    """A parameter is outside its bounds, or two parameters do not fit each other."""


class LayoutMismatch(TendrilError):
    """Two processes disagree about the layout of a record; neither may guess."""


class RigUnreachable(TendrilError):
    """The rig process did not answer in time."""


class CommandRefused(TendrilError):
    """The rig understood the command and refused it; the text says in which mode and why."""


class KeyRefused(TendrilError):
    """The rig's key is missing, or is not the one with which a message was sealed."""


class SessionUnknown(KeyRefused):
    """The rig does not know the session of a sealed message: it restarted since, or forgot a silent server."""


class Unproven(TendrilError):
    """What came over the link is not shown to be the rig's, in this boot of it, and new."""


class StartRefused(TendrilError):
    """A process could not start, and has said why in a sentence of its own."""


class ProcessKilled(TendrilError):
    """A process that worked for us was killed, or had to be."""


class RigHeld(CommandRefused):
    """Another server commands the rig; the text says which and since when."""


class NotAllowed(TendrilError):
    """The caller has no right to do this now (no session, no lease)."""


class RecordingError(TendrilError):
    """A recording cannot be written, found or read."""


def sentence(error: ValidationError) -> str:
    """The first complaint of `error` as one line: field = value: what is wrong."""
    return said(error.errors(include_url=False)[0])


def said(first: "ErrorDetails") -> str:
    """The same of one of its items."""
    field, text = ".".join(str(part) for part in first["loc"]), complaint(first)
    if not field:
        return text if first["type"] == "value_error" else f"message: {text}"
    whole = first["type"] == "missing" or isinstance(first["input"], dict)
    return f"{field}: {text}" if whole else f"{field} = {str(first['input'])[:60]}: {text}"


class DataError(TendrilError, ValueError):
    """A file of measured data cannot be used; the text names file, column, row, value and bound."""


def spelled(pattern: str, words: str, **more: Any) -> Any:
    """A bound for the `Annotated` type of a text: `pattern` for machines, `words` for who is refused."""
    _WORDS[pattern] = words
    return Bounds(pattern=pattern, **more)


def complaint(item: Mapping[str, Any]) -> str:
    """What is wrong, of an item of ValidationError.errors()."""
    text = str(item["msg"]).removeprefix("Value error, ")
    return _WORDS.get(item["ctx"]["pattern"], text) if item["type"] == "string_pattern_mismatch" else text
