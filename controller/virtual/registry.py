"""The far end that stands in for each device that a rig file may name; each is loaded when it is named."""

from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from controller.drivers.registry import capture_class, check_given, valve_class
from controller.errors import ParameterError
from controller.virtual.peers import CapturePeer, ReadPressures, TakeDrive, ValvePeer

Given = dict[str, Any]
"""Options of the rig file's driver."""
LOOPBACK = "127.0.0.1"
GROUP = "tendril.peers"
"""Entry points by which other packages bring the far end of a driver, under the driver's name."""
NEEDED = ("options", "plug", "unplug")
"""That no peer does without; what else a fault asks of it is refused where it is not there."""


def has_peer(driver: str) -> bool:
    """Whether `driver` can be tried without hardware."""
    return driver in (*CAPTURE_PEERS, *VALVE_PEERS, *_of_others())


def capture_peer(driver: str, options: Given) -> CapturePeer:
    """A camera for `driver`, at the addresses of `options`; ParameterError where nothing can stand in for it."""
    _require_peer("motion_capture", driver, CAPTURE_PEERS)
    check_given(capture_class(driver), options, "motion_capture")
    if driver in CAPTURE_PEERS:
        return CAPTURE_PEERS[driver](options)
    require_here(options, "motion_capture")
    found: CapturePeer = _class_of(driver, (*NEEDED, "show"))(options)
    return found


def valve_peer(driver: str, options: Given, read: ReadPressures, take: TakeDrive, patience: float = 0.0) -> ValvePeer:
    """A board for `driver`, likewise. Its rig waits for pressures for `patience` [s]: so long it waits for commands."""
    _require_peer("valves", driver, VALVE_PEERS)
    check_given(valve_class(driver), options, "valves")
    if driver in VALVE_PEERS:
        return VALVE_PEERS[driver](options | {"patience": patience}, read, take)
    require_here(options)
    found: ValvePeer = _class_of(driver, (*NEEDED, "close"))(options, read, take)
    return found


def _of_others() -> dict[str, EntryPoint]:
    """By the driver for which each stands in."""
    return {point.name: point for point in entry_points(group=GROUP)}


def _require_peer(table: str, driver: str, ours: Iterable[str]) -> None:
    if driver not in ours and driver not in _of_others():
        others = sorted(_of_others())
        raise ParameterError(
            f"{table}.driver = {driver}: only {', '.join([*ours, *others])} can be stood in for; a class of your own "
            f'can by an entry point "{GROUP}" (docs drivers)'
        )


def _class_of(driver: str, needed: Iterable[str]) -> Any:
    """The class of another package that stands in for `driver`; ParameterError where it does not load or lacks much."""
    point = _of_others()[driver]
    try:
        found = point.load()
    except (ImportError, AttributeError) as error:
        raise ParameterError(f"the peer of driver {driver} does not load: {point.value}: {error}") from error
    missing = [name for name in needed if not hasattr(found, name)]
    if missing:
        raise ParameterError(f"the peer of driver {driver}, {point.value}, has no {', '.join(missing)} (docs drivers)")
    return found


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


def require_here(given: Given, table: str = "valves") -> None:
    """ParameterError for a host that is not this machine: who drove it would drive the real one."""
    if given.get("host", LOOPBACK) not in (LOOPBACK, "localhost"):
        raise ParameterError(f"{table}.options.host = {given['host']}: a virtual rig is at {LOOPBACK}")


CAPTURE_PEERS: dict[str, Callable[[Given], CapturePeer]] = {"natnet": _natnet, "json": _json}
VALVE_PEERS: dict[str, Callable[[Given, ReadPressures, TakeDrive], ValvePeer]] = {
    "serial": _serial,
    "modbus": _modbus,
    "udp": _udp,
}
