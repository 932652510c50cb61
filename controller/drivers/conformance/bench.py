"""The far end of a driver that is tried, where it is not a lab's own device."""

from typing import Protocol

from controller.arrays import Array

RADIUS = 0.25
"""A camera on the bench shows a marker at this distance from its origin [m], always."""


class Driven(Protocol):
    """What the valves were told last."""

    @property
    def pressures(self) -> Array:
        """Setpoints by board channel [Pa]."""

    @property
    def openings(self) -> Array:
        """By board channel."""

    @property
    def raw(self) -> bool:
        """Openings are followed, not setpoints."""

    @property
    def vent(self) -> bool:
        """Every chamber is open."""

    @property
    def cut(self) -> bool:
        """The supply is cut."""


class Bench(Protocol):
    """A device that is not there, with chambers that follow its valves, or markers that it sees."""

    @property
    def options(self) -> dict[str, str | int]:
        """By which a driver reaches it."""

    def plug(self) -> None:
        """Begin to answer."""

    def unplug(self) -> None:
        """Vanish, as a cable that is pulled."""

    def silence(self) -> None:
        """Say nothing any more, over whatever connection there is; `plug` ends it."""

    def driven(self) -> Driven | None:
        """Of valves, what they were told last."""
