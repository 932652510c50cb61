"""What changes about the rig, the lease and the settings: one type each, published by the detector."""

from dataclasses import dataclass

from controller.schema.modes import Cause, Mode
from controller.schema.parameters import Settings
from server.http.who import Identity


@dataclass(frozen=True)
class BootChanged:
    """Another boot of the rig is heard now, or none; `met` is the one that was heard last, None before the first."""

    boot: int | None
    met: int | None


@dataclass(frozen=True)
class TroubleChanged:
    """Why the rig takes no command from this server, "" where it does again."""

    trouble: str


@dataclass(frozen=True)
class ModeChanged:
    """The rig's mode, or its cause, is another one from this tick on; `before` is None with the first row of a boot."""

    tick: int
    mode: Mode
    cause: Cause
    before: Mode | None


@dataclass(frozen=True)
class ObserverReseated:
    """The observer was wound, and begins again from the pose that fits the markers."""

    tick: int


@dataclass(frozen=True)
class LeaseChanged:
    """The lease passed from `before` to `holder`, one of whom may be None; `why` `before` lost it."""

    before: Identity | None
    holder: Identity | None
    why: str = ""


@dataclass(frozen=True)
class SettingsChanged:
    """The rig has taken these settings."""

    settings: Settings
