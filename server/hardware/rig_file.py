"""The rig file: read, checked, changed and put in force by a new start of the rig."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from controller.errors import CommandRefused, ParameterError
from controller.schema.parameters import RigParameters, Settings
from controller.schema.rig_file import parse_rig_file, read_rig_file, write_rig_file
from controller.system.whole_file import read_whole
from server.access.permit import Permit
from server.hardware import restart_files
from server.hardware.actuator import described
from server.hardware.messages import RigFileState
from server.hardware.outcomes import Change
from server.hardware.places import AllowedPlaces, places
from server.http.given import given
from server.rig.planner import Planner

NO_FILE = "the rig was started without a rig file: start it with `tendril up --rig FILE.toml`"


def accepted(text: str, path: Path, in_force: Settings) -> RigParameters:
    """The rig that `text` describes; ParameterError unless its drivers exist, and it stood and moved, simulated."""
    from controller.simulation.acceptance import accepted_rig  # in the planner only

    return accepted_rig(parse_rig_file(text, path.name), path.parent, in_force)


def named_now(path: Path) -> dict[str, str]:
    """The places that the file at `path` names; none where it is none."""
    try:
        return places(read_rig_file(path))
    except ParameterError:
        return {}


@dataclass(frozen=True)
class RigFileKeeper:
    """Reads and writes the file; the rig is restarted with what was written."""

    planner: Planner
    change: Change
    allowed: AllowedPlaces

    def state(self) -> RigFileState:
        """What lies there now."""
        path = self.change.settings.rig_file
        if path is None:
            return RigFileState(path="", text="", rig=None, reason=NO_FILE, in_force=False)
        text = ""
        try:
            text = read_whole(path).decode("utf-8-sig")
            found = parse_rig_file(text, path.name)
            info = self.change.rig.info
            runs = info is not None and found.parameters(path.parent) == info.parameters
            withdrawn = found.withdrawn(path.parent)
        except (OSError, UnicodeDecodeError, ParameterError) as error:
            return RigFileState(path=str(path), text=text, rig=None, reason=str(error), in_force=False)
        reason = restart_files.why_none(self.change.settings.restarts, "--rig FILE")
        return RigFileState(path=str(path), text=text, rig=found, reason=reason, in_force=runs, withdrawn=withdrawn)

    async def write(self, text: str, permit: Permit) -> None:
        """Put `text` in the file's place and start the rig with it.

        Raises CommandRefused unless the rig is VENTED, ours, and nothing is recorded; ParameterError naming field,
        value and bound, also where it names a place that it may not.
        """
        path = self._path()
        self.change.require_rest()
        found = parse_rig_file(text, path.name)
        if found.name != self.change.settings.rig:
            raise ParameterError(
                f"name = {found.name}: this server has rig {self.change.settings.rig}; it cannot change here"
            )
        self.allowed.learn((await self.planner.do(named_now, path)).values())
        self.allowed.require(await self.planner.do(places, found))
        wanted = await self.planner.do(accepted, text, path, self.change.operator.settings)
        self.change.require_rest()
        permit.require()
        try:
            write_rig_file(path, text)
        except OSError as error:
            raise CommandRefused(f"{path} cannot be written: {error.strerror}") from error
        restart_files.request_rig(self.change.settings.restarts, wanted, permit)
        self.change.requested(described(wanted), "its changed rig file", permit)

    def _path(self) -> Path:
        if self.change.settings.rig_file is None:
            raise CommandRefused(NO_FILE)
        return self.change.settings.rig_file


GivenRigFile = Annotated[RigFileKeeper, given(RigFileKeeper)]
