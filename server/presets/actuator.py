"""Another actuator for the rig: the server writes an order, and `tendril up`, the rig's parent, carries it out.

What was chosen is kept beside the settings, and the next `tendril up` begins with it.
"""

from pathlib import Path

from pydantic import ValidationError

from controller.actuator import PRESETS, Actuator, parse_actuator
from controller.build_rig import observer_model
from controller.errors import CommandRefused, ParameterError, TendrilError, sentence
from controller.parameters import RigParameters
from controller.whole_file import write_whole
from server.presets.messages import ActuatorBody
from server.settings import ServerSettings

ELSEWHERE = "the rig was not started by this server's `tendril up`: start it again with --actuator where it runs"


def wanted_actuator(body: ActuatorBody, rig: RigParameters) -> Actuator:
    """The actuator that `body` describes; ParameterError unless this rig's observer can be built for it."""
    if (body.name is None) == (body.toml is None):
        raise ParameterError("actuator: give either name or toml")
    if body.toml is not None:
        actuator = parse_actuator(body.toml, "the file")
    elif body.name in PRESETS:
        actuator = PRESETS[body.name]
    else:
        raise ParameterError(f"actuator = {body.name!r} is not one of {', '.join(PRESETS)}")
    observer_model(rig.model_copy(update={"actuator": actuator}))
    return actuator


def kept_file(settings: ServerSettings) -> Path:
    """Where this rig's choice is kept."""
    return settings.state / f"actuator-{settings.rig}.json"


def keep(path: Path, body: ActuatorBody) -> None:
    """Keep the choice for the next start; raises OSError where that fails."""
    write_whole(path, body.model_dump_json(exclude_none=True))


def kept_actuator(path: Path, rig: RigParameters) -> Actuator | None:
    """The actuator that was chosen last, None if none was; TendrilError when this rig cannot have it."""
    try:
        return wanted_actuator(ActuatorBody.model_validate_json(path.read_bytes()), rig)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise TendrilError(f"cannot be read: {error.strerror}") from error
    except ValidationError as error:
        raise TendrilError(f"is damaged: {sentence(error)}") from error


def order(path: Path | None, actuator: Actuator) -> None:
    """Have the rig started with `actuator`; CommandRefused where nobody would do it."""
    if path is None:
        raise CommandRefused(ELSEWHERE)
    try:
        write_whole(path, actuator.model_dump_json(), lasting=False)
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def take_order(path: Path) -> Actuator | None:
    """The actuator that was ordered since the last call, if any."""
    if not path.exists():
        return None
    found = Actuator.model_validate_json(path.read_bytes())
    path.unlink()
    return found
