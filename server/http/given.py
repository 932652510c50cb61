"""What routes ask for: parts of the server, by their class. So a room knows its own parts and those below it."""

from dataclasses import is_dataclass
from functools import cache
from typing import Annotated, Any, TypeVar, get_origin, get_type_hints

from fastapi import Depends, FastAPI
from starlette.requests import HTTPConnection

from server.settings import ServerSettings

T = TypeVar("T")


def give(app: FastAPI, parts: dict[type, object]) -> None:
    """Let the routes of `app` have these parts, each by its class."""
    app.state.parts = parts


def given(kind: type[T]) -> Any:
    """The server's one part of this class, for the `Annotated` type of a route's argument; or a dataclass whose fields
    name parts by their classes.
    """

    async def part(connection: HTTPConnection) -> T:
        return part_of(connection, kind)

    return Depends(part)


def part_of(connection: HTTPConnection, kind: type[T]) -> T:
    """The same where no route asks."""
    found = connection.app.state.parts.get(kind)
    if found is None and is_dataclass(kind):
        found = kind(**{name: part_of(connection, one) for name, one in _classes(kind).items()})
    assert isinstance(found, kind), f"this server has no {kind.__name__}"
    return found


@cache
def _classes(kind: type) -> dict[str, type]:
    """The class of each field; of a generic one that without its arguments."""
    return {name: get_origin(hint) or hint for name, hint in get_type_hints(kind).items()}


GivenSettings = Annotated[ServerSettings, given(ServerSettings)]
