"""What routes ask for: one part of the server, by its class. So a room knows its own parts and those below it."""

from typing import Annotated, Any, TypeVar

from fastapi import Depends, FastAPI
from starlette.requests import HTTPConnection

from server.settings import ServerSettings

T = TypeVar("T")


def give(app: FastAPI, parts: dict[type, object]) -> None:
    """Let the routes of `app` have these parts, each by its class."""
    app.state.parts = parts


def given(kind: type[T]) -> Any:
    """The server's one part of this class, for the `Annotated` type of a route's argument."""

    async def part(connection: HTTPConnection) -> T:
        return part_of(connection, kind)

    return Depends(part)


def part_of(connection: HTTPConnection, kind: type[T]) -> T:
    """The same where no route asks."""
    found = connection.app.state.parts[kind]
    assert isinstance(found, kind)
    return found


GivenSettings = Annotated[ServerSettings, given(ServerSettings)]
