"""The names by which browsers may ask for this server.

A foreign page whose own name is made to resolve to this machine (DNS rebinding) would count as our origin: on loopback
only loopback's names are answered. Elsewhere the names cannot be known, so all are, unless some are given.
"""

from collections.abc import Mapping
from ipaddress import IPv6Address

from server.settings import ServerSettings, exposed

LOOPBACK = ("localhost", "127.0.0.1", "[::1]")


class Hosts:
    """Judges the Host header of requests that come in on `port`."""

    def __init__(self, settings: ServerSettings) -> None:
        self._given = {name.lower() for name in settings.allow_host.split(",") if name}
        self._any = exposed(settings.host) and not self._given
        self._names = {*LOOPBACK, _in_address(settings.host).lower(), *self._given}
        self._standard = 443 if settings.tls_cert else 80

    def allows(self, headers: Mapping[str, str], port: int) -> bool:
        """Whether a request with these headers is meant for us; names that were given may come without the port."""
        bare = self._names if port == self._standard else self._given
        return self._any or headers.get("host", "").lower() in bare | {f"{name}:{port}" for name in self._names}


def _in_address(host: str) -> str:
    """`host` as it stands in an address."""
    try:
        return f"[{IPv6Address(host).compressed}]"
    except ValueError:
        return host
