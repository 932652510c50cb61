"""Settings that a procedure puts in force for a while, and puts back by whichever end it has.

What others have changed meanwhile stays as they have it.
"""

import asyncio
import contextlib
from dataclasses import dataclass
from typing import Protocol

from controller.errors import CommandRefused, TendrilError
from controller.schema.modes import Law, Request
from controller.schema.parameters import Settings
from server.access.permit import Permit
from server.operate.operator import Operator
from server.operate.settings import KeptSettings, put_in_force

RETRY_S = 1.0
"""Between two tries to put the settings back."""
BLIND = {"law": Law.OPEN_LOOP, "u_open": (0.0, 0.0), "sensed": 0}
"""An open loop without sensors."""


class OverrideNote(Protocol):
    """Where it is noted which settings are to be put back, for the next server if this one dies meanwhile."""

    @property
    def overridden(self) -> Settings | None:
        """Those of the operator; None where nothing is overridden."""

    def note_override(self, settings: Settings | None) -> None:
        """Note them, None once they are put back; raises OSError."""


@dataclass
class SettingsOverride:
    """Those of the operator and those in their place; only the event loop uses it."""

    operator: Operator
    kept: KeptSettings
    permit: Permit
    """Of what it asks for."""
    note: OverrideNote | None = None
    """With it a server that starts again begins with the override, too, and then puts it back."""
    before: Settings | None = None
    """What is to be put back."""
    ours: Settings | None = None
    """What it has asked for last; None: nothing is overridden."""
    former: Settings | None = None
    """What may be in force as well: while the rig is asked, and where it did not answer, what was before."""
    returning: bool = False
    """They are being put back."""

    @property
    def changed(self) -> bool:
        """Whether others have changed the settings meanwhile."""
        idle = self.ours is None or self.returning or self.kept.changing.locked()
        return not idle and self.operator.settings not in (self.ours, self.former)

    async def put(self, **changes: object) -> None:
        """Put the settings with `changes` in force, CommandRefused where others changed them or the rig refuses."""
        async with self.kept.changing:
            first, found = self.ours is None, self.operator.settings
            if not first and found != self.ours:
                raise CommandRefused("the settings were changed")
            if first:
                await self._begin(found)
            self.former, self.ours = found, found.model_copy(update=changes)
            await put_in_force(self.ours, self.operator, self.permit)
            self.former = self.ours
            if first and self.note is not None:
                await self.kept.keep(self.ours)

    async def restore(self) -> None:
        """Put the settings back, but for those that differ from ours; until the rig takes them."""
        while (ours := self.ours) is not None:
            async with self.kept.changing:
                found = self.operator.settings
                asked = (ours, self.former or ours)
                same = [name for name in Settings.model_fields if any(_alike(name, found, one) for one in asked)]
                wanted = found.model_copy(update={name: getattr(self.before, name) for name in same})
                with contextlib.suppress(TendrilError):
                    await put_in_force(wanted, self.operator, _restoring())
                    await self.kept.keep(self.operator.settings)
                    self.ours = None
            if self.ours is not None:
                await asyncio.sleep(RETRY_S)
        if self.note is not None and self.note.overridden is not None:
            with contextlib.suppress(OSError):  # it is tried again at the next start
                await asyncio.to_thread(self.note.note_override, None)
        self.returning = False

    async def _begin(self, found: Settings) -> None:
        self.before = found
        if self.note is None:
            return
        try:
            await asyncio.to_thread(self.note.note_override, found)
        except OSError as error:
            raise CommandRefused(f"the settings cannot be kept meanwhile: {error.strerror}") from error


def _alike(name: str, a: Settings, b: Settings) -> bool:
    return bool(getattr(a, name) == getattr(b, name))


def _restoring() -> Permit:
    """For the settings that were found; it covers no request."""
    return Permit(None, lambda request: "", frozenset({Request.NONE}))
