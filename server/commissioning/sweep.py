"""Soon."""

from typing import Any

from controller.errors import CommandRefused
from server.commissioning.store import Found


async def statics(*_: Any) -> Found:
    """Soon."""
    raise CommandRefused("not there yet")


decays = statics
