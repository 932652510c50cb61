"""The far end that stands in for each device that a rig file may name; each is loaded when it is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from controller.errors import ParameterError
from controller.virtual.peers import CapturePeer, ReadPressures, TakeDrive, ValvePeer

Given = dict[str, Any]
"""Options of the rig file's driver."""


def has_peer(driver: str) -> bool:
    """Whether `driver` can be tried without hardware."""
    return driver in CAPTURE_PEERS or driver in VALVE_PEERS


def capture_peer(driver: str, options: Given) -> CapturePeer:
    """A camera for `driver`, at the addresses of `options`; ParameterError where nothing can stand in for it."""
    if driver not in CAPTURE_PEERS:
        raise ParameterError(f"motion_capture.driver = {driver}: only {', '.join(CAPTURE_PEERS)} can be stood in for")
    return CAPTURE_PEERS[driver](options)


def valve_peer(driver: str, options: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    """A board for `driver`, likewise."""
    if driver not in VALVE_PEERS:
        raise ParameterError(f"valves.driver = {driver}: only {', '.join(VALVE_PEERS)} can be stood in for")
    return VALVE_PEERS[driver](options, read, take)


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

    return BoardPeer(read, take, Path(given["port"]) if given.get("port") else None)


def _modbus(given: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    from controller.virtual.modbus_server import ModbusPeer

    return ModbusPeer(read, take, given.get("port", 0), given.get("unit", 1))


def _udp(given: Given, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    from controller.virtual.udp_target import UdpTargetPeer

    return UdpTargetPeer(read, take, given.get("port", 0))


CAPTURE_PEERS: dict[str, Callable[[Given], CapturePeer]] = {"natnet": _natnet, "json": _json}
VALVE_PEERS: dict[str, Callable[[Given, ReadPressures, TakeDrive], ValvePeer]] = {
    "serial": _serial,
    "modbus": _modbus,
    "udp": _udp,
}
