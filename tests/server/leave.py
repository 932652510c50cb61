"""Permits for tests that have no server around them."""

from types import SimpleNamespace
from typing import cast

from server.access.lease import OperatorLease
from server.access.permit import Permit, Permits
from server.access.sessions import Sessions

ANYTHING = Permit(None, lambda request: "", sign=lambda: True)
"""Stands for ever."""


def permits_of(lease: OperatorLease) -> Permits:
    """Those of sessions that never end, with the rig's usual patience with the operator's page."""
    return Permits(lease, cast(Sessions, SimpleNamespace(stands=lambda who: True)), lambda: 0.5, lease._now)
