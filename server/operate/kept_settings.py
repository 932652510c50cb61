"""The rig's settings, kept over a restart of this server."""

import asyncio
from pathlib import Path
from typing import Annotated

from controller.schema.parameters import Settings
from controller.system.state_file import StateFile
from server.http.given import given
from server.log.events import EventLog


class KeptSettings:
    """`changing`: changes are merged one after another."""

    def __init__(self, path: Path, events: EventLog) -> None:
        self._file = StateFile(path, Settings.model_validate_json, "the rig begins with the default settings")
        self._events = events
        self.changing = asyncio.Lock()

    def read(self) -> Settings:
        """Those of the last run; the defaults when there are none, or none that this version understands."""
        return self._file.read() or Settings()

    async def keep(self, settings: Settings) -> None:
        """Remember what the rig has taken; it is in force even where that fails."""
        try:
            await asyncio.to_thread(self._file.write, settings.model_dump_json())
        except OSError as error:
            self._events.add(f"the settings will not outlive this server: {error}", "warning")


GivenKeptSettings = Annotated[KeptSettings, given(KeptSettings)]
