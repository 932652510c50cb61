"""`tendril stability` at the command line: growth of the observer and of the loop, and the loop's margins."""

from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from controller.errors import ParameterError
from controller.research.stability.stability import Question, Stability, stability
from controller.schema.origin import origin
from controller.schema.parameters import SENSORS, RigParameters
from controller.system.origin import command_line
from controller.system.progress import progress
from server.cli.files import require_file, write_json
from server.hardware.first_mode.messages import KeptMode, PlantNumber, in_force
from server.hardware.first_mode.store import FirstModes, modes_file
from server.settings import ServerSettings

GAIN_MOST = 1e6
"""Larger gains are not asked about [N/m, N s/m]."""


BOUNDS = {"zeta": (0.0, 2.0), "kappa": (0.1, 500.0)}
"""Of the plant's numbers."""


class Wanted(NamedTuple):
    """What is observed, how strongly, and what is known of the plant."""

    sense: str
    k_o: float
    b_o: float
    zeta: float | None = None
    kappa: float | None = None
    rig: str | None = None


def run_stability(parameters: RigParameters, wanted: Wanted, json_file: Path | None, console: Console) -> None:
    """Say how small motions grow; TendrilError says what is wrong."""
    if json_file is not None:
        require_file(json_file)
    for name, value in (("k-o", wanted.k_o), ("b-o", wanted.b_o)):
        if not 0.0 <= value <= GAIN_MOST:
            raise ParameterError(f"{name} = {value:g} is outside [0, {GAIN_MOST:g}]")
    plant = plant_of(parameters, wanted)
    twin = parameters.twin.model_copy(update={name: number.value for name, number in plant.items()})
    known = parameters.model_copy(update={"twin": twin})
    question = Question(known, sensors(wanted.sense), wanted.k_o, wanted.b_o)
    with progress(console, "Looking at every pose"):
        found = stability(question)
    for line in [*described(found), f"plant: {', '.join(plant_words(plant))}"]:
        console.print(line, markup=False, soft_wrap=True, highlight=False)
    if json_file is not None:
        made = origin(command_line(), actuators=(parameters.actuator,), controller=parameters.controller)
        numbers = {name: number.model_dump(mode="json") for name, number in plant.items()}
        write_json(json_file, found._asdict() | {"margins": found.margins._asdict(), "plant": numbers}, made)


def plant_of(parameters: RigParameters, wanted: Wanted) -> dict[str, PlantNumber]:
    """Damping ratio and kappa: those given, else those that `rig` measured of this actuator, else the twin's.

    Raises ParameterError for numbers out of bounds, and where that rig has measured nothing of it.
    """
    given = {"zeta": wanted.zeta, "kappa": wanted.kappa}
    for name, value in given.items():
        least, most = BOUNDS[name]
        if value is not None and not least <= value <= most:
            raise ParameterError(f"{name} = {value:g} is outside [{least:g}, {most:g}]")
    known = in_force(parameters, kept_of(parameters, wanted.rig) if wanted.rig is not None else None)
    return {
        name: getattr(known, name) if value is None else PlantNumber(value=value, source="given")
        for name, value in given.items()
    }


def kept_of(parameters: RigParameters, rig: str) -> KeptMode:
    """The last measurement of this very actuator on `rig`; ParameterError where there is none."""
    path, actuator = modes_file(ServerSettings(rig=rig).state, rig), parameters.actuator
    kept = FirstModes(path).of(actuator)
    if kept is None:
        raise ParameterError(f"rig = {rig}: no first mode of actuator {actuator.name} is kept in {path}")
    return kept


def plant_words(plant: dict[str, PlantNumber]) -> list[str]:
    """Each number, and where it comes from."""
    words = {"zeta": "damping ratio", "kappa": "kappa"}
    return [f"{words[name]} {number.value:.4g} ({_origin(number)})" for name, number in plant.items()]


def _origin(number: PlantNumber) -> str:
    if number.measured is None:
        return ": ".join(word for word in (number.source, number.note) if word)
    return f"{number.low:.3g} to {number.high:.3g}, measured {number.measured:%Y-%m-%d}"


def sensors(words: str) -> tuple[int, ...]:
    """Sensors of "6,10", counted from 0, base to tip."""
    try:
        found = sorted({int(word) for word in words.split(",")})
    except ValueError:
        raise ParameterError(f"sense = {words!r} is not a list of sensors, as in 6,10") from None
    for sensor in found:
        if not 1 <= sensor <= SENSORS:
            raise ParameterError(f"sense = {sensor} is outside [1, {SENSORS}]")
    return tuple(sensor - 1 for sensor in found)


def described(found: Stability) -> list[str]:
    """The figures in words."""
    u = ", ".join(f"{1e3 * torque:.0f}" for torque in found.growth_at)
    gain, phase, delay = found.margins
    loop = "stable" if found.closed_loop_stable else "NOT STABLE"
    return [
        f"{found.actuator}, {found.rods} rods, {found.integrator}, sensors {', '.join(map(str, found.sense))}",
        f"observer: growth {found.growth:.6f} per tick at worst, with torques of {u} mN m",
        f"the rig takes K_o up to {found.largest_k_o:.4g} N/m and B_o up to {found.largest_b_o:.4g} N s/m"
        + ("" if found.accepted else ": not these"),
        f"closed loop on the twin: growth {found.closed_loop_growth:.6f} per tick at worst, {loop}",
        f"margins: gain {gain:.2f}, phase {phase:.0f} degrees, delay {delay:.0f} ms",
    ]
