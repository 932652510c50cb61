"""How errors become answers: one status each, and a text that names field, value and bound."""

import itertools
import math
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
)
from server import refusals
from server.answers import refusal
from server.auth import TooManyAttempts, WrongToken
from server.live import Crowded
from server.rates import TooOften, TryLater
from server.references import UnknownReference

COMPLAINTS = 20
"""Faults of one request that are told."""
QUOTED, ITEMS, DEPTH = 500, 50, 6
"""Characters, items of a list and lists in lists of a wrong value that are told."""

_STATUS: dict[type[TendrilError], int] = {
    WrongToken: 401,
    NotAllowed: 403,
    RecordingError: 404,
    UnknownReference: 404,
    CommandRefused: 409,
    DataError: 422,
    ParameterError: 422,
    TooManyAttempts: 429,
    TooOften: 429,
    Crowded: 503,
    KeyRefused: 503,
    LayoutMismatch: 503,
    RigUnreachable: 503,
}


def install(app: FastAPI) -> None:
    """Answer our own errors with their status, and malformed requests with 422."""
    app.add_exception_handler(TendrilError, _answer)
    app.add_exception_handler(OSError, _disk)
    app.add_exception_handler(RequestValidationError, _malformed)
    app.add_exception_handler(HTTPException, _unread)


def malformed(error: ValidationError, *where: str) -> RequestValidationError:
    """`error` of a model inside a body, as if the body itself had been refused at `where`."""
    return RequestValidationError([{**item, "loc": (*where, *item["loc"])} for item in error.errors(include_url=False)])


def missing(*where: str) -> RequestValidationError:
    """A field is missing that this request needs."""
    return RequestValidationError([{"type": "missing", "loc": where, "msg": "Field required", "input": None}])


def answer(error: TendrilError) -> JSONResponse:
    """The answer that one of our own errors becomes."""
    status = next((code for kind, code in _STATUS.items() if isinstance(error, kind)), 503)
    return refusal(status, str(error), error.wait if isinstance(error, TryLater) else None)


async def _answer(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, TendrilError)
    await refusals.note(request, str(error))
    return answer(error)


async def _disk(request: Request, error: Exception) -> JSONResponse:
    """A folder that is gone, read-only or full is no fault of the program: 503, and one line in the log."""
    assert isinstance(error, OSError)
    where = f": {error.filename}" if error.filename else ""
    text = f"a file of the server cannot be read or written: {error.strerror or error}{where}"
    await refusals.note(request, text)
    return refusal(503, text)


async def _malformed(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    secret = request.url.path == "/api/session"
    await refusals.note(request, refusals.first_complaint(error, quote=not secret))
    items = [_complaint(item) for item in error.errors()[:COMPLAINTS]]
    return JSONResponse({"detail": items}, 422)


async def _unread(request: Request, error: Exception) -> Response:
    """A body that could not be read at all is malformed too; anything else is answered as it says."""
    assert isinstance(error, HTTPException)
    if error.status_code != 400 or error.__cause__ is None:
        return await http_exception_handler(request, error)
    why = "it is nested too deeply" if isinstance(error.__cause__, RecursionError) else str(error.__cause__)[:QUOTED]
    return await _malformed(request, unreadable("body", why))


def unreadable(where: str, why: str) -> RequestValidationError:
    """A part of the request that is not even JSON."""
    return RequestValidationError(
        [{"type": "unreadable", "loc": (where,), "msg": f"Cannot be read: {why}", "input": None}]
    )


def _complaint(item: dict[str, Any]) -> dict[str, Any]:
    """One fault in the form of `answers.Complaint`."""
    found = {name: _plain(item.get(name)) for name in ("type", "msg", "input")}
    return {**found, "loc": _plain(item["loc"], len(item["loc"])), "ctx": _plain(item.get("ctx") or {})}


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
