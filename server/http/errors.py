"""Errors of the server's own, each with the status that it is answered with."""

from typing import ClassVar

from controller.errors import TendrilError


class ServerError(TendrilError):
    """Refused by the server itself."""

    status: ClassVar[int] = 503


class NotFound(ServerError):
    """There is no such thing."""

    status = 404


class TryLater(ServerError):
    """Refused for now; `wait` says for how long it will be [s]."""

    status = 429
    wait: float
