"""The one form of every refusal, and when which is given: all routes document it from here."""

from typing import Any

from pydantic import JsonValue

from controller.layout import Model


class Complaint(Model):
    """One fault of a malformed request."""

    type: str
    loc: list[str | int]
    """Where: body, query or path, then the field and, in a list, the place."""
    msg: str
    """With the bound."""
    input: JsonValue
    """The value that was given; what is no JSON, as text."""
    ctx: dict[str, JsonValue]
    """The bound by itself, where there is one."""


class Problem(Model):
    """Body of every refusal: a sentence, or what is wrong with each field."""

    detail: str | list[Complaint]


_WHEN = {
    400: "No HTTP request, or a range that is none",
    401: "Not signed in",
    403: "From another origin, or without the operator's lease",
    404: "There is no such thing",
    409: "Not in this state",
    411: "A body without its length",
    413: "The body is too long",
    422: "Field, value and bound of what is wrong",
    429: "Too often; the header retry-after says for how long to wait [s]",
    500: "The server's disk or a file of its own fails",
    503: "The rig does not answer, or takes no command from this server",
}
REFUSALS: dict[int | str, dict[str, Any]] = {
    status: {"model": Problem, "description": when} for status, when in _WHEN.items()
}


def body(media: str, what: str) -> dict[int | str, dict[str, Any]]:
    """Documents the answer of a route that sends `what`, of type `media`, instead of JSON."""
    binary = {"type": "string", "format": "binary"}
    return {200: {"content": {media: {"schema": binary}}, "description": what}}


def file(*media: str) -> dict[int | str, dict[str, Any]]:
    """Documents the answers of a route that sends a file, of one of the types `media`, whole or a range of it."""
    content = {one: {"schema": {"type": "string", "format": "binary"}} for one in media}
    ranges = content | {"multipart/byteranges": {"schema": {"type": "string", "format": "binary"}}}
    return {
        200: {"content": content, "description": "The file"},
        206: {"content": ranges, "description": "The range that was asked for"},
        400: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "A range that is none"},
        416: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "A range beyond the end"},
    }
