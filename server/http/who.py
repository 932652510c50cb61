"""Who asks: what a signed-in browser is known by, everywhere."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal, get_args

from fastapi import Depends
from starlette.requests import HTTPConnection

from controller.errors import NotAllowed

Role = Literal["operator", "viewer"]
"""What a token is good for: to operate (one session at a time, by the lease), or to look and stop."""
ROLES: tuple[Role, ...] = get_args(Role)


@dataclass(frozen=True)
class Identity:
    """One signed-in browser (or script): a random id, and a name that people can read out."""

    id: str
    name: str
    role: Role = "viewer"
    opened_by: str = ""
    """Mark of the token that opened the session: another token of that role ends it."""
    user: str = ""
    """Names the browser in what it keeps for itself, over changes of its role too; "": as `id` does."""

    budget: str = ""
    """Whose share of the rates it uses, of sessions that were opened too fast one after the other; "": its own."""

    @property
    def client(self) -> str:
        """By what its requests and messages are counted."""
        return self.budget or self.id

    def is_session(self, other: "Identity | None") -> bool:
        """Whether `other` is this very session: an id counts only with the token that opened it."""
        return other is not None and (self.id, self.opened_by) == (other.id, other.opened_by)

    @property
    def described(self) -> str:
        """The name, and the role where that is not to operate."""
        return self.name if self.role == "operator" else f"{self.name} ({self.role})"

    @cached_property
    def tag(self) -> str:
        """Names this session to others, who must not know its id."""
        return hashlib.sha256(f"{self.id} {self.opened_by}".encode()).hexdigest()[:12]


async def _me(connection: HTTPConnection) -> Identity:
    who: Identity | None = connection.state.who
    if who is None:
        raise NotAllowed("sign in first")
    return who


Me = Annotated[Identity, Depends(_me)]
"""The signed-in session that asks; the gate has checked it."""
