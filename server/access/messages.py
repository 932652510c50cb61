"""What sign-in and lease look like on the wire."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model
from server.http.who import Role


class Login(Model):
    """Body of POST /api/session: the access token printed by `tendril up`."""

    token: Annotated[str, Bounds(min_length=1, max_length=200)]


class Lease(Model):
    """Who operates. At most one session holds it; it lapses when its page is gone."""

    held: bool
    mine: bool
    holder: str
    """Short name of the holder's session, "" when free."""
    clutch: bool
    """Held clutch: a target moves only while it is held, and letting go holds the rig."""
    lost: str
    """Why the session that asks operates no longer, "" where it does, or has not since this server started."""


class Session(Model):
    """Who I am."""

    name: str
    role: Role
    """Whose token I signed in with."""
    unprotected: bool
    """Other machines can reach this server, and what is said to it travels unencrypted."""
    lease: Lease
