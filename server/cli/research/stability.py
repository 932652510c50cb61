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

GAIN_MOST = 1e6
"""Larger gains are not asked about [N/m, N s/m]."""


class Wanted(NamedTuple):
    """What is observed, and how strongly."""

    sense: str
    k_o: float
    b_o: float


def run_stability(parameters: RigParameters, wanted: Wanted, json_file: Path | None, console: Console) -> None:
    """Say how small motions grow; TendrilError says what is wrong."""
    if json_file is not None:
        require_file(json_file)
    for name, value in (("k-o", wanted.k_o), ("b-o", wanted.b_o)):
        if not 0.0 <= value <= GAIN_MOST:
            raise ParameterError(f"{name} = {value:g} is outside [0, {GAIN_MOST:g}]")
    question = Question(parameters, sensors(wanted.sense), wanted.k_o, wanted.b_o)
    with progress(console, "Looking at every pose"):
        found = stability(question)
    for line in described(found):
        console.print(line, markup=False, soft_wrap=True, highlight=False)
    if json_file is not None:
        made = origin(command_line(), actuators=(parameters.actuator,), controller=parameters.controller)
        write_json(json_file, found._asdict() | {"margins": found.margins._asdict()}, made)


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
