"""The rig file: read, checked, changed and put in force by a new start of the rig."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from controller.errors import CommandRefused, ParameterError
from controller.schema.parameters import RigParameters, Settings
from controller.schema.rig_file import parse_rig_file, write_rig_file
from controller.system.whole_file import read_whole
from server.access.permit import Permit
from server.hardware.messages import RigFileState
from server.http.given import given
from server.log.events import EventLog
from server.operate.operator import Operator
from server.presets import order_files
from server.presets.actuator import described
from server.presets.change import Change
from server.presets.outcomes import OutcomeWatch
from server.rig.client import Rig
from server.rig.planner import Planner
from server.settings import ServerSettings

NO_FILE = "the rig was started without a rig file: start it with `tendril up --rig FILE.toml`"


def accepted(text: str, path: Path, in_force: Settings) -> RigParameters:
    """The rig that `text` describes; ParameterError unless its drivers exist, and it stood and moved, simulated."""
    from controller.simulation.acceptance import accepted_rig  # in the planner only

    return accepted_rig(parse_rig_file(text, path.name), path.parent, in_force)


@dataclass(frozen=True)
class RigFileKeeper:
    """Reads and writes the file; the rig is started anew with what was written."""

    rig: Rig
    planner: Planner
    operator: Operator
    outcomes: OutcomeWatch
    events: EventLog
    settings: ServerSettings
    change: Change

    def state(self) -> RigFileState:
        """What lies there now."""
        path = self.settings.rig_file
        if path is None:
            return RigFileState(path="", text="", rig=None, reason=NO_FILE, in_force=False)
        text = ""
        try:
            text = read_whole(path).decode("utf-8-sig")
            found = parse_rig_file(text, path.name)
            runs = found.parameters(path.parent) == self.rig.require_info().parameters if self.rig.info else False
        except (OSError, UnicodeDecodeError, ParameterError) as error:
            return RigFileState(path=str(path), text=text, rig=None, reason=str(error), in_force=False)
        reason = order_files.why_none(self.settings.orders, "--rig FILE")
        return RigFileState(path=str(path), text=text, rig=found, reason=reason, in_force=runs)

    async def write(self, text: str, permit: Permit) -> None:
        """Put `text` in the file's place and start the rig with it.

        Raises CommandRefused unless the rig is VENTED, ours, and nothing is recorded; ParameterError naming field,
        value and bound.
        """
        path = self._path()
        self.change.require_rest()
        found = parse_rig_file(text, path.name)
        if found.name != self.settings.rig:
            raise ParameterError(f"name = {found.name}: this server has rig {self.settings.rig}; it cannot change here")
        wanted = await self.planner.do(accepted, text, path, self.operator.settings)
        self.change.require_rest()
        permit.require()
        try:
            write_rig_file(path, text)
        except OSError as error:
            raise CommandRefused(f"{path} cannot be written: {error.strerror}") from error
        order_files.order_rig(self.settings.orders, wanted, permit)
        self.outcomes.wait_for(described(wanted), self.rig.boot())
        self.events.add(f"{permit.name}: the rig starts again with its changed rig file", "warning")

    def _path(self) -> Path:
        if self.settings.rig_file is None:
            raise CommandRefused(NO_FILE)
        return self.settings.rig_file


GivenRigFile = Annotated[RigFileKeeper, given(RigFileKeeper)]
