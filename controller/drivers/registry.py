"""Drivers by name: ours, and those of installed packages (entry points of the group "tendril.drivers")."""

from collections.abc import Iterable, Iterator
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Literal

from pydantic import ValidationError

from controller.drivers.device import CaptureDevice, Device, ValveDevice
from controller.errors import ParameterError, said, sentence
from controller.schema.hardware import MotionCapture, Valves
from controller.system.origin import install_command

GROUP = "tendril.drivers"
OURS = {
    "natnet": "controller.drivers.capture.natnet.driver:NatNet",
    "motioncapture": "controller.drivers.capture.vendor:Vendor",
    "json": "controller.drivers.capture.json_udp:JsonCapture",
    "lsl": "controller.drivers.capture.lsl:LslCapture",
    "ros2": "controller.drivers.capture.ros2:Ros2Capture",
    "serial": "controller.drivers.valves.serial_board.driver:SerialBoard",
    "udp": "controller.drivers.valves.udp_target:UdpTarget",
    "modbus": "controller.drivers.valves.modbus.driver:ModbusValves",
    "nidaq": "controller.drivers.valves.nidaq:NiDaq",
}
"""Module and class; loaded when named, because some need a package that is an extra."""


def driver_names() -> dict[str, str]:
    """Every driver that could be loaded: name to where it comes from."""
    found = {point.name: point.value for point in entry_points(group=GROUP)}
    return found | OURS


def driver_class(name: str) -> type[Device[Any]]:
    """The driver `name`; ParameterError where there is none, or its package is missing."""
    places = driver_names()
    if name not in places:
        raise ParameterError(f"driver = {name}: {_there_are(places)}")
    module, _, attribute = places[name].partition(":")
    try:
        found = getattr(import_module(module), attribute)
    except ImportError as error:
        remedy = install_command(name) if name in OURS else "install what the package that brings it needs"
        raise ParameterError(f"driver = {name}: {error}; {remedy}") from error
    if not (isinstance(found, type) and issubclass(found, Device)):
        raise ParameterError(f"driver = {name}: {places[name]} is not a driver")
    return found


def capture_device(asked: MotionCapture) -> CaptureDevice[Any]:
    """The device that `asked` names, not yet open; ParameterError naming field, value and bound."""
    kind = capture_class(asked.driver)
    return kind(checked_options(kind, asked.options, "motion_capture"))


def capture_class(name: str) -> type[CaptureDevice[Any]]:
    """The driver `name` for motion capture; ParameterError where it is none."""
    kind = _class_of(name, "motion_capture")
    if not issubclass(kind, CaptureDevice):
        raise ParameterError(f"motion_capture.driver = {name} drives valves")
    return kind


def valve_device(asked: Valves) -> ValveDevice[Any]:
    """The board that `asked` names, not yet open; ParameterError naming field, value and bound."""
    kind = valve_class(asked.driver)
    return kind(checked_options(kind, asked.options, "valves"), asked.chambers, asked.command == "opening")


def valve_class(name: str) -> type[ValveDevice[Any]]:
    """The driver `name` for valves; ParameterError where it is none."""
    kind = _class_of(name, "valves")
    if not issubclass(kind, ValveDevice):
        raise ParameterError(f"valves.driver = {name} gives no pressures and takes none")
    return kind


def _there_are(names: Iterable[str]) -> str:
    return f"there are {', '.join(sorted(names))}"


def _class_of(name: str, table: Literal["motion_capture", "valves"]) -> type[Device[Any]]:
    if name not in driver_names():
        room = ".capture." if table == "motion_capture" else ".valves."
        raise ParameterError(f"{table}.driver = {name}: {_there_are(_fitting(room))}")
    try:
        return driver_class(name)
    except ParameterError as error:
        raise ParameterError(f"{table}.{error}") from error


def _fitting(room: str) -> Iterator[str]:
    """Ours of that kind, and every other package's: what those are is known once they are loaded."""
    return (name for name, place in driver_names().items() if name not in OURS or room in place)


def checked_options(kind: type[Device[Any]], options: dict[str, Any], table: str) -> Any:
    """`options` as the driver's own model; ParameterError naming `table`."""
    try:
        return kind.Options.model_validate(options)
    except ValidationError as error:
        raise ParameterError(f"{table}.options.{sentence(error)}") from error


def check_given(kind: type[Device[Any]], options: dict[str, Any], table: str) -> None:
    """As `checked_options`, but what is left out, or a port of 0, may be filled in later."""
    try:
        kind.Options.model_validate(options)
    except ValidationError as error:
        for one in error.errors(include_url=False):
            if one["type"] != "missing" and not (str(one["loc"][-1]).endswith("port") and one["input"] == 0):
                raise ParameterError(f"{table}.options.{said(one)}") from error
