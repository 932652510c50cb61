"""What was asked for in vain goes into the log: who asked, for what, and why not. Reading is not asking."""

from fastapi import Request
from pydantic import BaseModel

from server.http.given import part_of
from server.log.events import EventLog

_READING = ("GET", "HEAD", "OPTIONS")
_LONGEST = 200
"""Characters of a reason that are kept: it may quote what a stranger sent."""
_NAME = 40


class _Asked(BaseModel):
    """The part of a command's body that names it, right or wrong."""

    request: str


async def note(request: Request, reason: str) -> None:
    """Write the refusal of `request` into the log."""
    if request.method in _READING:
        return
    part_of(request, EventLog).refused(_who(request), await _what(request), reason[:_LONGEST])


def _who(request: Request) -> str:
    who = request.state.who
    if who is not None:
        return str(who.name)
    return f"someone at {request.client.host}" if request.client else "someone"


async def _what(request: Request) -> str:
    """The rig's request by its own name, everything else by the name of its route."""
    name: str = request.scope["route"].name
    if name == "command":
        try:
            name = _Asked.model_validate_json(await request.body()).request
        except ValueError:
            pass  # no JSON, or none that names a request
    return name[:_NAME].replace("_", "-" if name == "e_stop" else " ")
