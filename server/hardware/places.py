"""Devices, hosts and files that a rig file names, and which of them the page may put into it.

The page may name what the file named before the page first changed it, and what TENDRIL_ALLOW_REACH allows: whoever
operates could else have the rig open any device, talk to any host, and read any file of its user.
"""

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from typing import Any, Literal, get_origin

from pydantic import BaseModel

from controller.drivers.registry import OURS, capture_class, checked_options, valve_class
from controller.errors import ParameterError
from controller.schema.rig_file import RigFile

SHOWN = 5
"""Places that a refusal names."""


def places(found: RigFile) -> dict[str, str]:
    """Each place that a rig of this file reaches, by its field; what is left out has the driver's default.

    A driver of another package is a place, too: what it reaches by a number cannot be known. Raises ParameterError
    where a driver or its options are none.
    """
    capture, valves = found.motion_capture, found.valves
    options = checked_options(capture_class(capture.driver), capture.options, "motion_capture")
    said = dict(_texts("motion_capture.options", options))
    said |= _texts("valves.options", checked_options(valve_class(valves.driver), valves.options, "valves"))
    drivers = {"motion_capture.driver": capture.driver, "valves.driver": valves.driver}
    said |= {field: name for field, name in drivers.items() if name not in OURS}
    if isinstance(found.actuator, str) and "/" in found.actuator:  # a bare name lies beside the rig file
        said["actuator"] = found.actuator
    return said


def _texts(field: str, value: Any) -> Iterator[tuple[str, str]]:
    """Every text in the options, by its field, but those that are one of a few words."""
    if isinstance(value, BaseModel):
        for name, about in type(value).model_fields.items():
            if get_origin(about.annotation) is not Literal:
                yield from _texts(f"{field}.{name}", getattr(value, name))
    elif isinstance(value, dict | list | tuple):
        for place in value if isinstance(value, dict) else range(len(value)):
            yield from _texts(f"{field}.{place}", value[place])
    elif isinstance(value, str) and value:
        yield field, value


class AllowedPlaces:
    """What the page may name. Only the event loop uses it."""

    def __init__(self, allow: str) -> None:
        """`allow`: more than the file names, with commas between; * stands for anything."""
        self._patterns = [pattern for pattern in allow.split(",") if pattern]
        self._known: set[str] = set()

    def learn(self, named: Iterable[str]) -> None:
        """The file names these, and the page did not put them there."""
        self._known |= set(named)

    def require(self, wanted: dict[str, str]) -> None:
        """ParameterError with field and value for the first place that is not allowed."""
        for field, place in wanted.items():
            if place not in self._known and not any(fnmatchcase(place, pattern) for pattern in self._patterns):
                known = sorted(self._known)
                more = ", ..." if len(known) > SHOWN else ""
                named = ", ".join(known[:SHOWN]) + more or "nothing"
                raise ParameterError(
                    f"{field} = {place[:60]}: the page may name what the file named at the start ({named}); change it "
                    "in the file itself, or start with TENDRIL_ALLOW_REACH"
                )
