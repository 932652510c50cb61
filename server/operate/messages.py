"""What an operator asks for, and who else is here, on the wire."""

from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.layout import Model
from controller.schema.messages import Coordinate
from controller.schema.parameters import Settings
from controller.schema.slot import TUNING
from server.http.who import Role

PresetName = Annotated[str, spelled(r"^[\w .+-]{1,60}$", "1 to 60 letters, digits, blanks and _ . + -")]


class Person(Model):
    """A session as others see it."""

    tag: Annotated[str, Bounds(pattern=r"^[0-9a-f]{12}$")]
    """Names the session; its id stays its own."""
    name: str
    role: Role
    """Whose token it signed in with."""


class People(Model):
    """Who is here, and who wants to operate."""

    holder: str
    """Tag of the operator, "" when no one does."""
    asking: list[Person]
    """Who asked for control, the longest waiting first."""
    others: list[Person]
    """Whose pages are open, but mine."""
    waiting: bool
    """I asked, and no one has answered."""


class SessionTag(Model):
    """Body of requests about another session: which one."""

    tag: Annotated[str, Bounds(pattern=r"^[0-9a-f]{12}$")]


class LeaseBody(Model):
    """Body of PATCH /api/lease: how the holder operates."""

    clutch: bool


class CommandBody(Model):
    """Body of POST /api/command."""

    request: Literal["arm", "hold", "follow", "rest", "clear", "e_stop"]
    target: tuple[Coordinate, Coordinate] | None = None
    """Needed by `follow`; metres in the plane frame."""


class SettingsBody(Model):
    """Body of PATCH /api/settings: only the fields to change (same names and bounds as `Settings`)."""

    changes: Annotated[dict[str, float | int | Annotated[list[float], Bounds(max_length=16)]], Bounds(max_length=64)]


class ControllerBody(Model):
    """Body of PUT /api/controller: which of the rig's controllers is to be in the slot."""

    name: Annotated[str, Bounds(max_length=60)]
    """Of `RigInfo.controllers`."""
    tuning: Annotated[dict[Annotated[str, Bounds(max_length=60)], float], Bounds(max_length=TUNING)] | None = None
    """Its own numbers by name; the others are as usual."""


class Target(Model):
    """The operator moved the target. `start` marks a fresh action (press): only it may leave HOLD."""

    type: Literal["target"]
    id: Annotated[int, Bounds(ge=0)]
    x: Coordinate
    y: Coordinate
    start: bool = False


class Release(Model):
    """The operator let go of the target: with the held clutch on, the rig then holds."""

    type: Literal["release"]
    hold: bool = False
    """Hold whatever the clutch is: the page ended the drag, because its plan moved under the pointer."""


class EStop(Model):
    """Stop the rig at once: anyone who is signed in may, however often. Answered by a Reply, or Refused, with its n."""

    type: Literal["e_stop"]
    n: Annotated[int, Bounds(ge=0, lt=2**53)]


class Refused(Model):
    """A message on the socket was refused before it reached the rig."""

    type: Literal["refused"] = "refused"
    id: int
    detail: str
    n: int | None = None
    """Of the EStop that did not arrive; null for anything else."""


class Presence(Model):
    """The operator's page is alive: a counter that only it advances, sent at 20 Hz while it holds the lease.

    The page says so on /ws/presence, from a worker; a script may on its live socket.
    """

    type: Literal["presence"]
    n: Annotated[int, Bounds(ge=0)]


class GainPreset(Model):
    """Settings that were saved under a name; the page loads law, gains and limits from them."""

    name: str
    settings: Settings
    built_in: bool = False
    """It comes with Tendril: neither replaced nor deleted."""
