"""Virtual peers by the name of the driver that speaks to them; each is loaded when it is named."""

from importlib import import_module
from typing import Any

from controller.errors import ParameterError

CAPTURE_PEERS = {
    "natnet": "controller.virtual.natnet_server:NatNetServer",
    "json": "controller.virtual.json_source:JsonSource",
}
VALVE_PEERS = {
    "serial": "controller.virtual.board:BoardPeer",
    "modbus": "controller.virtual.modbus_server:ModbusPeer",
    "udp": "controller.virtual.udp_target:UdpTargetPeer",
}


def has_peer(driver: str) -> bool:
    """Whether `driver` can be tried without hardware."""
    return driver in CAPTURE_PEERS or driver in VALVE_PEERS


def peer_class(driver: str) -> Any:
    """Class of the peer of `driver`; ParameterError where there is none."""
    place = (CAPTURE_PEERS | VALVE_PEERS).get(driver)
    if place is None:
        known = ", ".join(sorted(CAPTURE_PEERS | VALVE_PEERS))
        raise ParameterError(f"driver = {driver} has no virtual peer; {known} have one")
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
