"""Requests for another actuator, plant or rig: files that the server writes, and `tendril up`, the rig's parent, takes.

Only when the rig has ticked with it an actuator is kept for the next start of `tendril up`. If it does not, the rig
goes back to what ticked last. Either way `up` writes an outcome, which the server tells the page. A plant or a rig is
asked for in the same way; the next start has those that it is told.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from controller.errors import CommandRefused
from controller.schema.actuator import Actuator
from controller.schema.parameters import RigParameters
from controller.system.whole_file import write_whole
from server.hardware.messages import ActuatorBody, ActuatorOutcome

if TYPE_CHECKING:  # `tendril up` reads requests, and needs no web framework for it
    from server.access.permit import Permit

CHOICE, RIG, OUTCOME = "actuator-choice.json", "rig.json", "actuator-outcome.json"
"""Files beside that of an actuator that was asked for, whose path names them all."""


def why_none(path: Path | None, option: str = "--actuator") -> str:
    """Why no one would do what is asked, "" where it would be; `option` of `tendril up` does the same by hand."""
    elsewhere = f"the rig was not started by this server's `tendril up`: start it again with {option} where it runs"
    return elsewhere if path is None else ""


def request_actuator(path: Path | None, actuator: Actuator, body: ActuatorBody, permit: "Permit") -> None:
    """Have the rig started with `actuator`, which `body` describes, if `permit` stands; CommandRefused where no one
    would do it.
    """
    choice = body.model_dump_json(exclude_none=True)
    _write(path, {CHOICE: choice, "": actuator.model_dump_json()}, "--actuator", permit)


def request_rig(path: Path | None, wanted: RigParameters, permit: "Permit", option: str = "--rig FILE") -> None:
    """Have the rig started with all of `wanted`, if `permit` stands; CommandRefused where no one would do it."""
    _write(path, {RIG: wanted.model_dump_json()}, option, permit)


def _write(path: Path | None, texts: dict[str, str], option: str, permit: "Permit") -> None:
    """Write the texts to the files of these names, "" being `path` itself, in this order."""
    if path is None:
        raise CommandRefused(why_none(path, option))
    permit.require()
    try:
        for name, text in texts.items():
            write_whole(path.with_name(name or path.name), text, lasting=False)
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def take_rig(path: Path) -> RigParameters | None:
    """The whole rig that was asked for since the last call, if any."""
    text = _taken(path.with_name(RIG))
    return None if text is None else RigParameters.model_validate_json(text)


def take_actuator(path: Path) -> Actuator | None:
    """The actuator that was asked for since the last call, if any."""
    text = _taken(path)
    return None if text is None else Actuator.model_validate_json(text)


def _taken(file: Path) -> bytes | None:
    if not file.exists():
        return None
    text = file.read_bytes()
    file.unlink()
    return text


def take_choice(path: Path) -> ActuatorBody | None:
    """How the actuator of the last request was described; None if that was not said."""
    try:
        return ActuatorBody.model_validate_json(path.with_name(CHOICE).read_bytes())
    except (OSError, ValidationError):
        return None


def tell_outcome(path: Path, outcome: ActuatorOutcome) -> None:
    """Let the server know what became of a request; raises OSError where that fails."""
    write_whole(path.with_name(OUTCOME), outcome.model_dump_json(), lasting=False)


def take_outcome(path: Path) -> ActuatorOutcome:
    """What became of the last request; FileNotFoundError where that is not known yet, OSError or ValidationError."""
    file = path.with_name(OUTCOME)
    outcome = ActuatorOutcome.model_validate_json(file.read_bytes())
    file.unlink()
    return outcome
