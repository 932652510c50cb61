"""The far end that stands in for each device that a rig file may name; each is loaded when it is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from controller.drivers.registry import capture_class, check_given, valve_class
from controller.errors import ParameterError
from controller.virtual.peers import CapturePeer, ReadPressures, TakeDrive, ValvePeer

Given = dict[str, Any]
"""Options of the rig file's driver."""
LOOPBACK = "127.0.0.1"


def has_peer(driver: str) -> bool:
    """Whether `driver` can be tried without hardware."""
    return driver in CAPTURE_PEERS or driver in VALVE_PEERS


def capture_peer(driver: str, options: Given) -> CapturePeer:
    """A camera for `driver`, at the addresses of `options`; ParameterError where nothing can stand in for it."""
    if driver not in CAPTURE_PEERS:
        raise ParameterError(f"motion_capture.driver = {driver}: only {', '.join(CAPTURE_PEERS)} can be stood in for")
    check_given(capture_class(driver), options, "motion_capture")
    return CAPTURE_PEERS[driver](options)


def valve_peer(driver: str, options: Given, read: ReadPressures, take: TakeDrive, patience: float = 0.0) -> ValvePeer:
    """A board for `driver`, likewise. Its rig waits for pressures for `patience` [s]: so long it waits for commands."""
    if driver not in VALVE_PEERS:
        raise ParameterError(f"valves.driver = {driver}: only {', '.join(VALVE_PEERS)} can be stood in for")
    check_given(valve_class(driver), options, "valves")
    return VALVE_PEERS[driver](options | {"patience": patience}, read, take)


def _natnet(given: Given) -> CapturePeer:
    from controller.virtual.natnet_server import NatNetServer

    version = given.get("version", "auto")
    return NatNetServer(
        "4.1" if version == "auto" else version,
        multicast=given.get("multicast_address", ""),
        address=given.get("server", "127.0.0.1"),
        command_port=given.get("command_port", 0),
        data_port=given.get("data_port", 0),
    )


def _json(given: Given) -> CapturePeer:
    from controller.virtual.json_source import JsonSource

    return JsonSource(port=given.get("port", 0))


def _serial(given: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    from controller.virtual.board import BoardPeer

    return BoardPeer(read, take, Path(given["port"]) if given.get("port") else None, given["patience"])


def _modbus(given: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    from controller.virtual.modbus_server import ModbusPeer

    require_here(given)
    return ModbusPeer(read, take, given.get("port", 0), given.get("unit", 1))


def _udp(given: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    from controller.virtual.udp_target import UdpTargetPeer

    require_here(given)
    return UdpTargetPeer(read, take, given.get("port", 0))


def require_here(given: Given) -> None:
    """ParameterError for a host that is not this machine: who drove it would drive the real one."""
    if given.get("host", LOOPBACK) not in (LOOPBACK, "localhost"):
        raise ParameterError(f"valves.options.host = {given['host']}: a virtual rig is at {LOOPBACK}")


CAPTURE_PEERS: dict[str, Callable[[Given], CapturePeer]] = {"natnet": _natnet, "json": _json}
VALVE_PEERS: dict[str, Callable[[Given, ReadPressures, TakeDrive], ValvePeer]] = {
    "serial": _serial,
    "modbus": _modbus,
    "udp": _udp,
}
