"""How errors become answers: one status each, and a text that names field, value and bound."""

import itertools
import math
from collections.abc import Awaitable, Callable
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exception_handlers import http_exception_handler
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse

from controller.errors import (
    CommandRefused,
    DataError,
    KeyRefused,
    LayoutMismatch,
    NotAllowed,
    ParameterError,
    RecordingError,
    RigUnreachable,
    TendrilError,
    complaint,
)
from server.http.answers import refusal
from server.http.errors import ServerError, TryLater

COMPLAINTS = 20
"""Faults of one request that are told."""
QUOTED, ITEMS, DEPTH = 500, 50, 6
"""Characters, items of a list and lists in lists of a wrong value that are told."""

_STATUS: dict[type[TendrilError], int] = {
    NotAllowed: 403,
    RecordingError: 404,
    CommandRefused: 409,
    DataError: 422,
    ParameterError: 422,
    KeyRefused: 503,
    LayoutMismatch: 503,
    RigUnreachable: 503,
}
"""Of errors that rig and recordings raise, too; the server's own know theirs."""

Note = Callable[[Request, str], Awaitable[None]]
"""Hears what was refused, and why."""


def install(app: FastAPI, note: Note) -> None:
    """Answer our own errors with their status, and malformed requests with 422; `note` hears of each."""
    answers = Answers(note)
    app.add_exception_handler(TendrilError, answers.known)
    app.add_exception_handler(OSError, answers.disk)
    app.add_exception_handler(RequestValidationError, answers.malformed)
    app.add_exception_handler(HTTPException, answers.unread)


def malformed(error: ValidationError, *where: str) -> RequestValidationError:
    """`error` of a model inside a body, as if the body itself had been refused at `where`."""
    return RequestValidationError([{**item, "loc": (*where, *item["loc"])} for item in error.errors(include_url=False)])


def missing(*where: str) -> RequestValidationError:
    """A field is missing that this request needs."""
    return RequestValidationError([{"type": "missing", "loc": where, "msg": "Field required", "input": None}])


def answer(error: TendrilError) -> JSONResponse:
    """The answer that one of our own errors becomes."""
    known = next((code for kind, code in _STATUS.items() if isinstance(error, kind)), 503)
    status = error.status if isinstance(error, ServerError) else known
    return refusal(status, str(error), error.wait if isinstance(error, TryLater) else None)


class Answers:
    """What an error becomes, and who hears of it."""

    def __init__(self, note: Note) -> None:
        self._note = note

    async def known(self, request: Request, error: Exception) -> JSONResponse:
        """One of our own: it says itself what is wrong."""
        assert isinstance(error, TendrilError)
        await self._note(request, str(error))
        return answer(error)

    async def disk(self, request: Request, error: Exception) -> JSONResponse:
        """A folder that is gone, read-only or full is no fault of the program: 503, and one line in the log."""
        assert isinstance(error, OSError)
        where = f": {error.filename}" if error.filename else ""
        text = f"a file of the server cannot be read or written: {error.strerror or error}{where}"
        await self._note(request, text)
        return refusal(503, text)

    async def malformed(self, request: Request, error: Exception) -> JSONResponse:
        """Field, value and bound of everything that is wrong."""
        assert isinstance(error, RequestValidationError)
        secret = request.url.path == "/api/session"
        await self._note(request, first_complaint(error, quote=not secret))
        items = [_complaint(item) for item in error.errors()[:COMPLAINTS]]
        return JSONResponse({"detail": items}, 422)

    async def unread(self, request: Request, error: Exception) -> Response:
        """A body that could not be read at all is malformed too; anything else is answered as it says."""
        assert isinstance(error, HTTPException)
        if error.status_code == 404 and b"%2f" in request.scope.get("raw_path", b"").lower():
            return refusal(404, "no name has a / in it; choose another one")
        if error.status_code != 400 or error.__cause__ is None:
            return await http_exception_handler(request, error)
        deep = isinstance(error.__cause__, RecursionError)
        why = "it is nested too deeply" if deep else str(error.__cause__)[:QUOTED]
        return await self.malformed(request, unreadable("body", why))


def unreadable(where: str, why: str) -> RequestValidationError:
    """A part of the request that is not even JSON."""
    return RequestValidationError(
        [{"type": "unreadable", "loc": (where,), "msg": f"Cannot be read: {why}", "input": None}]
    )


def first_complaint(error: RequestValidationError, *, quote: bool) -> str:
    """The first fault of a malformed request as one line: field = value: what is wrong; `quote` shows the value."""
    first = error.errors()[0]
    field = ".".join(str(part) for part in first["loc"] if part not in ("body", "changes"))
    given = first.get("input")
    value = "" if not quote or given is None or isinstance(given, dict) else f" = {str(given)[:60]}"
    return f"{field}{value}: {complaint(first)}".removeprefix(": ")


def _complaint(item: dict[str, Any]) -> dict[str, Any]:
    """One fault in the form of `answers.Complaint`."""
    found = {name: _plain(item.get(name)) for name in ("type", "input")}
    return {
        **found,
        "msg": _plain(complaint(item)),
        "loc": _plain(item["loc"], len(item["loc"])),
        "ctx": _plain(item.get("ctx") or {}),
    }


def _plain(value: Any, most: int = ITEMS, depth: int = DEPTH) -> Any:
    """What JSON can carry, and not much of it: the value may be nan, an exception, no Unicode, or without end."""
    if isinstance(value, dict | list | tuple) and depth == 0:
        return "..."
    if isinstance(value, dict):
        some = itertools.islice(value.items(), most)
        return {_plain(str(key)): _plain(item, most, depth - 1) for key, item in some}
    if isinstance(value, list | tuple):
        return [_plain(item, most, depth - 1) for item in value[:most]]
    if value is None or isinstance(value, bool) or (isinstance(value, float) and math.isfinite(value)):
        return value
    if isinstance(value, int) and abs(value) < 2**63:
        return value
    text = f"{value:.3g}" if isinstance(value, int) and abs(value) < 10**300 else _text(value)
    return text.encode(errors="backslashreplace").decode()


def _text(value: Any) -> str:
    """The beginning of it in words."""
    if isinstance(value, int):
        return f"a number of {value.bit_length()} bits"
    text = str(value)
    return text if len(text) <= QUOTED else f"{text[:QUOTED]}..."
