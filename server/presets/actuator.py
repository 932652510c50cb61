"""Another actuator or plant for the rig: the server writes an order, `tendril up`, the rig's parent, carries it out.

Only when the rig has ticked with it the choice is kept beside the settings, for the next `tendril up` to begin with. If
it does not, the rig goes back to what ticked last. Either way `up` writes an outcome, which the server tells the page.
A plant is ordered in the same way; the next start has the one it is told.
"""

import time
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import ValidationError

from controller.errors import CommandRefused, ParameterError, TendrilError, sentence
from controller.schema.actuator import PRESETS, Actuator, parse_actuator
from controller.schema.parameters import PlantKind, RigParameters, Settings
from controller.system.whole_file import read_whole, set_aside, write_whole
from server.access.permit import Permit
from server.http.given import given
from server.log.events import EventLog
from server.presets.messages import ActuatorBody, ActuatorOutcome, PlantBody
from server.settings import ServerSettings

ELSEWHERE = "the rig was not started by this server's `tendril up`: start it again with --actuator where it runs"
LOOK = 0.25
"""Pause between two looks for an outcome [s]."""
LONGEST = 90.0
"""Most time for the rig to come back after an order [s], be it with the actuator before; then it counts as silent."""


def accepted_actuator(body: ActuatorBody, rig: RigParameters, in_force: Settings) -> Actuator:
    """The actuator that `body` describes; ParameterError unless this rig was built with it and stood and moved here."""
    from controller.simulation.acceptance import require_running  # in the planner only

    actuator = wanted_actuator(body, rig)
    require_running(rig.with_actuator(actuator), in_force)
    return actuator


def wanted_actuator(body: ActuatorBody, rig: RigParameters) -> Actuator:
    """The actuator that `body` describes; ParameterError unless all of this rig can be built for it."""
    from controller.simulation.acceptance import require_built

    if (body.name is None) == (body.toml is None):
        raise ParameterError("actuator: give either name or toml")
    if body.toml is not None:
        actuator = parse_actuator(body.toml, "the file")
    elif body.name in PRESETS:
        actuator = PRESETS[body.name]
    else:
        raise ParameterError(f"actuator = {body.name!r} is not one of {', '.join(PRESETS)}")
    require_built(rig.with_actuator(actuator))
    return actuator


def with_plant(rig: RigParameters, plant: PlantKind) -> RigParameters:
    """The same rig on another plant."""
    return rig.model_copy(update={"twin": rig.twin.model_copy(update={"plant": plant})})


def accepted_plant(plant: PlantKind, rig: RigParameters, in_force: Settings) -> str:
    """What the rig on `plant` is called; ParameterError unless it stood and moved here."""
    from controller.simulation.acceptance import require_running  # in the planner only

    wanted = with_plant(rig, plant)
    require_running(wanted, in_force)
    return described(wanted)


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


def kept_actuator(path: Path, rig: RigParameters) -> Actuator | None:
    """The actuator that was chosen last, None if none was; TendrilError when this rig cannot have it."""
    try:
        return wanted_actuator(ActuatorBody.model_validate_json(read_whole(path)), rig)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise TendrilError(f"cannot be read: {error.strerror}") from error
    except ValidationError as error:
        raise TendrilError(f"is damaged: {sentence(error)}") from error


def order(path: Path | None, actuator: Actuator, body: ActuatorBody, permit: Permit) -> None:
    """Have the rig started with `actuator`, which `body` describes, if `permit` stands; CommandRefused where nobody
    would do it.
    """
    if path is None:
        raise CommandRefused(ELSEWHERE)
    permit.require()
    try:
        write_whole(_choice_file(path), body.model_dump_json(exclude_none=True), lasting=False)
        write_whole(path, actuator.model_dump_json(), lasting=False)
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def order_plant(path: Path | None, plant: PlantKind, permit: Permit) -> None:
    """Have the rig started on `plant`, if `permit` stands; CommandRefused where nobody would do it."""
    if path is None:
        raise CommandRefused(ELSEWHERE.replace("--actuator", "--plant"))
    permit.require()
    try:
        write_whole(_plant_file(path), PlantBody(plant=plant).model_dump_json(), lasting=False)
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def order_rig(path: Path | None, wanted: RigParameters, permit: Permit) -> None:
    """Have the rig started with all of `wanted`, if `permit` stands; CommandRefused where nobody would do it."""
    if path is None:
        raise CommandRefused(ELSEWHERE.replace("--actuator", "--rig FILE"))
    permit.require()
    try:
        write_whole(_rig_file(path), wanted.model_dump_json(), lasting=False)
    except OSError as error:
        raise CommandRefused(f"the rig cannot be started again: {error.strerror}") from error


def take_rig(path: Path | None) -> RigParameters | None:
    """The whole rig that was ordered since the last call, if any."""
    if path is None or not (ordered := _rig_file(path)).exists():
        return None
    found = RigParameters.model_validate_json(ordered.read_bytes())
    ordered.unlink()
    return found


def take_plant(path: Path | None) -> PlantKind | None:
    """The plant that was ordered since the last call, if any."""
    if path is None or not (ordered := _plant_file(path)).exists():
        return None
    found = PlantBody.model_validate_json(ordered.read_bytes())
    ordered.unlink()
    return found.plant


def take_order(path: Path | None) -> Actuator | None:
    """The actuator that was ordered since the last call, if any."""
    if path is None or not path.exists():
        return None
    found = Actuator.model_validate_json(path.read_bytes())
    path.unlink()
    return found


def take_choice(path: Path) -> ActuatorBody | None:
    """How the actuator of the last order was described; None if that was not said."""
    try:
        return ActuatorBody.model_validate_json(_choice_file(path).read_bytes())
    except (OSError, ValidationError):
        return None


def tell_outcome(path: Path, outcome: ActuatorOutcome) -> None:
    """Let the server know what became of an order; raises OSError where that fails."""
    write_whole(_outcome_file(path), outcome.model_dump_json(), lasting=False)


def _choice_file(orders: Path) -> Path:
    return orders.with_name("actuator-choice.json")


def _plant_file(orders: Path) -> Path:
    return orders.with_name("plant.json")


def _rig_file(orders: Path) -> Path:
    return orders.with_name("rig.json")


def _outcome_file(orders: Path) -> Path:
    return orders.with_name("actuator-outcome.json")


class Awaited(NamedTuple):
    """A rig that was told to start with another actuator."""

    actuator: str
    boot: int | None
    """Boot of the rig that is to end."""
    end: float
    """Until when it may take [s on the monotonic clock]."""


class OutcomeWatch:
    """Tells what became of an order for another actuator."""

    watched = "another actuator"

    def __init__(self, settings: ServerSettings, events: EventLog) -> None:
        self._settings, self._events = settings, events
        self._due, self._blind = 0.0, False
        self.failure = ""
        """Why the last actuator that was asked for is not in force, "" if it is."""
        self._awaited: Awaited | None = None
        self._settled = False

    def wait_for(self, actuator: str, boot: int | None) -> None:
        """The rig, which runs as `boot`, was told to start with `actuator`."""
        self._settled = self._blind
        self._awaited = Awaited(actuator, boot, time.monotonic() + LONGEST)

    def starting(self, boot: int | None) -> str:
        """Actuator with which the rig was told to start and has not yet, "" for none; `boot` is the one heard now.

        It has once it is known how that went, and the boot that came of it is heard.
        """
        wanted = self._awaited
        if wanted is None:
            return ""
        back = self._settled and boot not in (None, wanted.boot)
        if back or time.monotonic() > wanted.end:
            self._awaited = None
            return ""
        return wanted.actuator

    def look(self) -> None:
        """Look, now and then."""
        if self._settings.orders is None or self._blind or time.monotonic() < self._due:
            return
        self._due = time.monotonic() + LOOK
        try:
            path = _outcome_file(self._settings.orders)
            outcome = ActuatorOutcome.model_validate_json(path.read_bytes())
            path.unlink()
        except FileNotFoundError:
            return
        except (OSError, ValidationError) as error:
            self._blind = self._settled = True
            self._events.add(f"what becomes of another actuator will not be told here: {error}", "warning")
            return
        self._tell(outcome)

    def _tell(self, outcome: ActuatorOutcome) -> None:
        self._settled = True
        self.failure = told(outcome) if outcome.reason else ""
        if outcome.reason:
            self._events.add(self.failure, "error")
        elif outcome.unkept:
            self._events.add(f"the next start will not have this actuator: {outcome.unkept}", "warning")


def told(outcome: ActuatorOutcome) -> str:
    """A failed order in one sentence."""
    return f"actuator {outcome.actuator} did not start: {outcome.reason}; {outcome.in_force} is in force again"


GivenOutcomes = Annotated[OutcomeWatch, given(OutcomeWatch)]
