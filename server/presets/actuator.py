"""Another actuator for the rig: the server writes an order, and `tendril up`, the rig's parent, carries it out."""

from pathlib import Path

from controller.actuator import PRESETS, Actuator, parse_actuator
from controller.build_rig import observer_model
from controller.errors import CommandRefused, ParameterError
from controller.parameters import RigParameters
from server.presets.messages import ActuatorBody
from server.settings import write_private

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


def order(path: Path | None, actuator: Actuator) -> None:
    """Have the rig started with `actuator`; CommandRefused where nobody would do it."""
    if path is None:
        raise CommandRefused(ELSEWHERE)
    try:
        write_private(path, actuator.model_dump_json())
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def take_order(path: Path) -> Actuator | None:
    """The actuator that was ordered since the last call, if any."""
    if not path.exists():
        return None
    found = Actuator.model_validate_json(path.read_bytes())
    path.unlink()
    return found
