"""Texts of a given spelling, whose refusal says in words what they may hold."""

from collections.abc import Mapping
from typing import Any

from pydantic import Field as Bounds

_WORDS: dict[str, str] = {}


def spelled(pattern: str, words: str, **more: Any) -> Any:
    """A bound for the `Annotated` type of a text: `pattern` for machines, `words` for who is refused."""
    _WORDS[pattern] = words
    return Bounds(pattern=pattern, **more)


def complaint(item: Mapping[str, Any]) -> str:
    """What is wrong, of an item of ValidationError.errors()."""
    text = str(item["msg"]).removeprefix("Value error, ")
    return _WORDS.get(item["ctx"]["pattern"], text) if item["type"] == "string_pattern_mismatch" else text
