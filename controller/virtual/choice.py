"""The far end that stands in for each device that a rig file may name."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from controller.errors import ParameterError
from controller.schema.hardware import MotionCapture, Valves
from controller.virtual.peers import CapturePeer, ReadPressures, TakeDrive, ValvePeer

Given = dict[str, Any]
"""Options of the rig file's driver."""


def capture_peer(asked: MotionCapture) -> CapturePeer:
    """A camera for the driver that `asked` names; ParameterError where nothing can stand in for it."""
    found: CapturePeer = _known(CAMERAS, asked.driver, "motion_capture")(asked.options)
    return found


def valve_peer(asked: Valves, read: ReadPressures, take: TakeDrive) -> ValvePeer:
    """A board for the driver that `asked` names; ParameterError where nothing can stand in for it."""
    found: ValvePeer = _known(BOARDS, asked.driver, "valves")(asked.options, read, take)
    return found


def _known(peers: dict[str, Any], driver: str, table: str) -> Any:
    if driver not in peers:
        raise ParameterError(f"{table}.driver = {driver}: only {', '.join(peers)} can be stood in for")
    return peers[driver]


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


CAMERAS: dict[str, Callable[[Given], CapturePeer]] = {"natnet": _natnet, "json": _json}
BOARDS: dict[str, Callable[[Given, ReadPressures, TakeDrive], ValvePeer]] = {
    "serial": _serial,
    "modbus": _modbus,
    "udp": _udp,
}
