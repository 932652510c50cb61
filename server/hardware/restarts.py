"""The restarts that the server asks for, with another actuator or plant, in `tendril up`, the rig's parent."""

import logging
from pathlib import Path

from controller.realtime.supervisor import Started, Supervisor
from server.hardware.actuator import described, keep, with_other_actuator
from server.hardware.messages import ActuatorBody, ActuatorOutcome
from server.hardware.restart_files import take_actuator, take_choice, take_rig, tell_outcome

log = logging.getLogger(__name__)


class Restarts:
    """What the server asked for, another actuator or plant: carried out, and told back; kept once the rig ticked."""

    def __init__(self, path: Path, kept: Path, supervisor: Supervisor) -> None:
        """`path` is where it asks, `kept` where the choice is for the next start."""
        self._path, self._kept, self._supervisor = path, kept, supervisor
        self._choice: ActuatorBody | None = None

    def look(self) -> None:
        """Start the rig as was asked; say what became of the last one."""
        if (actuator := take_actuator(self._path)) is not None:
            self._choice = take_choice(self._path)
            parameters = self._supervisor.settings.parameters
            self._supervisor.replace(with_other_actuator(parameters, actuator))
        if (wanted := take_rig(self._path)) is not None:
            self._supervisor.replace(wanted)
        if (started := self._supervisor.started()) is not None:
            self._settle(started)

    def _settle(self, started: Started) -> None:
        unkept = ""
        if not started.reason and self._choice is not None:
            unkept = self._keep(self._choice)
        outcome = ActuatorOutcome(
            actuator=described(started.parameters),
            reason=started.reason,
            in_force=described(self._supervisor.settings.parameters),
            unkept=unkept,
        )
        self._choice = None
        try:
            tell_outcome(self._path, outcome)
        except OSError as error:
            log.warning("the page is not told what became of actuator %s: %s", outcome.actuator, error)

    def _keep(self, choice: ActuatorBody) -> str:
        try:
            keep(self._kept, choice)
        except OSError as error:
            return error.strerror or str(error)
        return ""
