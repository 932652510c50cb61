"""How errors become answers: one status each, and a text that names field, value and bound."""

import math
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
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
from server.auth import TooManyAttempts, WrongToken
from server.references import UnknownReference

_STATUS: dict[type[TendrilError], int] = {
    WrongToken: 401,
    NotAllowed: 403,
    RecordingError: 404,
    UnknownReference: 404,
    CommandRefused: 409,
    DataError: 422,
    ParameterError: 422,
    TooManyAttempts: 429,
    KeyRefused: 503,
    LayoutMismatch: 503,
    RigUnreachable: 503,
}


def install(app: FastAPI) -> None:
    """Answer our own errors with their status, and malformed requests with 422."""
    app.add_exception_handler(TendrilError, _answer)
    app.add_exception_handler(RequestValidationError, _malformed)


def malformed(error: ValidationError, *where: str) -> RequestValidationError:
    """`error` of a model inside a body, as if the body itself had been refused at `where`."""
    return RequestValidationError([{**item, "loc": (*where, *item["loc"])} for item in error.errors(include_url=False)])


def missing(*where: str) -> RequestValidationError:
    """A field is missing that this request needs."""
    return RequestValidationError([{"type": "missing", "loc": where, "msg": "Field required", "input": None}])


async def _answer(request: Request, error: Exception) -> JSONResponse:
    status = next((code for kind, code in _STATUS.items() if isinstance(error, kind)), 500)
    headers = {"retry-after": "60"} if status == 429 else None
    await refusals.note(request, str(error))
    return JSONResponse({"detail": str(error)}, status, headers)


async def _malformed(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    secret = request.url.path == "/api/session"
    await refusals.note(request, refusals.first_complaint(error, quote=not secret))
    items = [{name: _plain(value) for name, value in item.items() if name != "url"} for item in error.errors()]
    return JSONResponse({"detail": items}, 422)


def _plain(value: Any) -> Any:
    """What JSON can carry: the offending value may be nan, bytes, an exception, or text that is no Unicode."""
    if isinstance(value, dict):
        return {_plain(str(key)): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, bool | int) or (isinstance(value, float) and math.isfinite(value)):
        return value
    return str(value).encode(errors="backslashreplace").decode()
