"""The one form of every refusal, when which is given, and how many were: all routes document it from here."""

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from pydantic import JsonValue
from starlette.responses import JSONResponse

from controller.schema.layout import Model


class Complaint(Model):
    """One fault of a malformed request."""

    type: str
    loc: list[str | int]
    """Where: body, query or path, then the field and, in a list, the place."""
    msg: str
    """With the bound."""
    input: JsonValue
    """The value that was given; as text where it is not JSON."""
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
    421: "This server has another name",
    422: "Field, value and bound of what is wrong",
    429: "Too often; the header retry-after says for how long to wait [s]",
    431: "The request line and its headers are too long",
    500: "The server's disk or a file of its own fails",
    503: "The rig does not answer, or takes no command from this server",
}
JSON_LINES = "application/x-ndjson"
"""An answer that comes line by line, each of them JSON (https://jsonlines.org)."""
_PROBLEM = {"application/json": {"schema": {"$ref": f"#/components/schemas/{Problem.__name__}"}}}
REFUSALS: dict[int | str, dict[str, Any]] = {
    status: {"description": when, "content": _PROBLEM} for status, when in _WHEN.items()
}
"""By reference: from a model FastAPI would make a validator for each status of each route, a second at every start."""


def say_once(schema: dict[str, Any]) -> None:
    """Put every refusal once among the components of the OpenAPI `schema`, and let the operations refer to it."""
    told = {str(status): one for status, one in REFUSALS.items()}
    described = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    schema["components"]["schemas"] |= described.pop("$defs") | {Problem.__name__: described}
    schema["components"]["responses"] = {f"Refused{status}": one for status, one in told.items()}
    for methods in (schema["paths"] | schema["webhooks"]).values():
        for operation in methods.values():
            same = [status for status, one in operation["responses"].items() if one == told.get(status)]
            references = {status: {"$ref": f"#/components/responses/Refused{status}"} for status in same}
            operation["responses"].update(references)


def refusal(status: int, detail: str, wait: float | None = None) -> JSONResponse:
    """A refusal by one sentence; `wait` tells for how long to stay away [s]."""
    headers = None if wait is None else {"retry-after": str(math.ceil(wait))}
    return JSONResponse({"detail": detail}, status, headers)


def json_line(said: Model) -> str:
    """`said` as a line of its own."""
    return said.model_dump_json() + "\n"


def body(media: str, what: str) -> dict[int | str, dict[str, Any]]:
    """Documents the answer of a route that sends `what`, of type `media`, instead of JSON."""
    return {200: {"content": _binary(media), "description": what}}


def file(*media: str) -> dict[int | str, dict[str, Any]]:
    """Documents the answers of a route that sends a file, of one of the types `media`, whole or a range of it."""
    return {
        200: {"content": _binary(*media), "description": "The file"},
        206: {"content": _binary(*media, "multipart/byteranges"), "description": "The range that was asked for"},
        400: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "A range that is none"},
        416: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "A range beyond the end"},
    }


def _binary(*media: str) -> dict[str, Any]:
    return {one: {"schema": {"type": "string", "format": "binary"}} for one in media}


@dataclass
class RefusedCounts:
    """Since this server started: a rising number is someone's mistake, or an attempt. Only the event loop counts."""

    requests: Counter[int] = field(default_factory=Counter)
    """Requests and sockets by the status of their answer, 400 and above."""
    messages: int = 0
    """Messages on live sockets."""
    signatures: int = 0
    """Cookies that this server did not sign, or not with its present token."""

    def answer(self, status: int) -> None:
        """Count an answer, if it is a refusal."""
        if status >= 400:
            self.requests[status] += 1
