"""What a viewer's session may do, decided once for every route: it may read, and what `VIEWERS` names.

Everything else that changes something needs the operator's token, or the lease that an operator has handed over; so a
new route is closed to viewers until it is named here. Who of the operators may act now is the lease's matter
(`server.access.permit.Holder`). Sockets are open to all: what is said on them is judged by the lease, one by one.
"""

from starlette.requests import HTTPConnection

from controller.errors import NotAllowed
from server.access.lease import OperatorLease
from server.http.given import part_of
from server.http.who import Identity

READING = ("GET", "HEAD", "OPTIONS")
VIEWERS = frozenset(
    {
        "sign_in_by_token",
        "sign_out",
        "command",  # E-STOP is for everyone; the route itself demands the lease for all else
        "ask_for_lease",
        "withdraw_request",
        # nothing is kept of these
        "plan_drawing",
        "text_path",
        "import_path",
        "propose_path",
        "preview",
        "preview_parts",
        "make_export",
        # one's own, that no one else sees
        "keep_layout",
        "delete_layout",
        "keep_alarms",
        "reset_alarms",
        "change_look",
        "change_path",
        "play",
        "end_playback",
    }
)
"""Names of the routes that change something and are open to viewers."""


def operates(who: Identity, lease: OperatorLease) -> bool:
    """Whether `who` may do what operators do: by the token, or because an operator handed the lease over."""
    return who.role == "operator" or lease.holds(who)


async def authorise(connection: HTTPConnection) -> None:
    """Dependency of every route; raises `NotAllowed` for what a viewer's session may not do."""
    scope = connection.scope
    if scope["type"] == "websocket" or scope["method"] in READING or scope["route"].name in VIEWERS:
        return
    who: Identity | None = connection.state.who
    if who is None or not operates(who, part_of(connection, OperatorLease)):
        raise NotAllowed("you signed in with the viewer's token: it is for looking, and for the E-STOP")
