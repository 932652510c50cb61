"""Another actuator or plant: which ones this rig can have, and the choice that is kept for its next start."""

from pathlib import Path

from pydantic import ValidationError

from controller.errors import ParameterError, TendrilError, sentence
from controller.schema.actuator import PRESETS, Actuator, parse_actuator
from controller.schema.parameters import RigParameters, Settings, usual_kappa, usual_twin
from controller.schema.twin_numbers import twin_numbers
from controller.system.whole_file import read_whole, set_aside, write_whole
from server.hardware.messages import ActuatorBody, PlantBody
from server.settings import ServerSettings


def accepted_actuator(body: ActuatorBody, rig: RigParameters, in_force: Settings) -> Actuator:
    """The actuator that `body` describes; ParameterError unless this rig was built with it and stood and moved here."""
    from controller.simulation.acceptance import require_built, require_running  # in the planner only

    actuator = wanted_actuator(body)
    wanted = with_other_actuator(rig, actuator)
    require_built(wanted)
    require_running(wanted, in_force)
    return actuator


def with_other_actuator(rig: RigParameters, actuator: Actuator, observer_kappa: float | None = None) -> RigParameters:
    """The same rig with `actuator`, and in its observer with `observer_kappa`, or else with what is usual with that
    actuator: what was measured is another's.
    """
    kappa = usual_kappa(actuator, rig.controller.integrator) if observer_kappa is None else observer_kappa
    return with_observer_kappa(rig.with_actuator(actuator), kappa)


def wanted_actuator(body: ActuatorBody) -> Actuator:
    """The actuator that `body` describes; ParameterError where it describes none."""
    if (body.name is None) == (body.toml is None):
        raise ParameterError("actuator: give either name or toml")
    if body.toml is not None:
        return parse_actuator(body.toml, "the file")
    if body.name not in PRESETS:
        raise ParameterError(f"actuator = {body.name!r} is not one of {', '.join(PRESETS)}")
    return PRESETS[body.name]


def accepted_plant(body: PlantBody, rig: RigParameters, in_force: Settings) -> RigParameters:
    """The same rig on another plant; ParameterError unless it stood and moved here."""
    from controller.simulation.acceptance import require_running  # in the planner only

    numbers = rig.twin if body.numbers is None else usual_twin(rig.body, twin_numbers(body.numbers))
    wanted = rig.model_copy(update={"twin": numbers.model_copy(update={"plant": body.plant})})
    require_running(wanted, in_force)
    return wanted


def with_observer_kappa(rig: RigParameters, kappa: float) -> RigParameters:
    """The same rig with the inertia of its table over `kappa` in the observer."""
    return rig.model_copy(update={"controller": rig.controller.model_copy(update={"observer_kappa": kappa})})


def accepted_observer_kappa(kappa: float, rig: RigParameters, in_force: Settings) -> RigParameters:
    """The rig with `kappa` in its observer; ParameterError unless it stood and moved here."""
    from controller.simulation.acceptance import require_running  # in the planner only

    wanted = with_observer_kappa(rig, kappa)
    require_running(wanted, in_force)
    return wanted


def described(rig: RigParameters) -> str:
    """The actuator, and the plant where that is not rods: "P1 as a Cosserat rod"."""
    return rig.actuator.name + (" as a Cosserat rod" if rig.twin.plant == "cosserat" else "")


def kept_file(settings: ServerSettings) -> Path:
    """Where this rig's choice is kept."""
    return settings.state / f"actuator-{settings.rig}.json"


def keep(path: Path, body: ActuatorBody) -> None:
    """Keep the choice for the next start; raises OSError where that fails."""
    if path.is_dir():
        set_aside(path)
    write_whole(path, body.model_dump_json(exclude_none=True))


def kept_actuator(path: Path) -> Actuator | None:
    """The actuator that was chosen last, None if none was; TendrilError when what is kept describes none."""
    try:
        return wanted_actuator(ActuatorBody.model_validate_json(read_whole(path)))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise TendrilError(f"cannot be read: {error.strerror}") from error
    except ValidationError as error:
        raise TendrilError(f"is damaged: {sentence(error)}") from error
