"""`tendril statics` at the command line: the static equilibrium of an actuator under torques and gravity."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from controller.assembly.rod import computable
from controller.assembly.statics import scratch_for, static_map
from controller.errors import ParameterError
from controller.kernels.model.equilibrium import out_of_balance
from controller.kernels.model.polygon import admissible
from controller.kernels.model.sensitivity import sensitivity
from controller.kernels.model.statics import static_tip
from controller.schema.origin import origin
from controller.schema.parameters import RigParameters
from controller.system.origin import command_line
from server.cli.files import require_file, write_json

TORQUE_MAX = 10.0
"""Largest torque, in units of the actuator's u_max: far beyond what its chambers can do."""


def run_statics(parameters: RigParameters, words: str, json_file: Path | None, console: Console) -> None:
    """Say where the arm comes to rest under the torques in `words`; TendrilError says what is wrong."""
    if json_file is not None:
        require_file(json_file)
    u = torques(words, parameters.actuator.u_max)
    found = figures(parameters, u)
    for line in described(found):
        console.print(line, markup=False, soft_wrap=True, highlight=False)
    if json_file is not None:
        made = origin(command_line(), actuators=(parameters.actuator,), controller=parameters.controller)
        write_json(json_file, found._asdict(), made)


def torques(words: str, u_max: float) -> tuple[float, float]:
    """u1 and u2 [N m] of "U1,U2"."""
    try:
        u1, u2 = (float(word) for word in words.split(","))
    except ValueError:
        raise ParameterError(f"u = {words!r} is not two torques [N m], as in 0.02,-0.01") from None
    for name, value in (("u_1", u1), ("u_2", u2)):
        if not abs(value) <= TORQUE_MAX * u_max:
            bound = TORQUE_MAX * u_max
            raise ParameterError(f"{name} = {value:g} N m is outside [{-bound:g}, {bound:g}], {TORQUE_MAX:g} u_max")
    return u1, u2


class Equilibrium(NamedTuple):
    """Where an arm comes to rest, as the JSON file has it."""

    actuator: str
    rods: int
    u: tuple[float, float]
    """[N m]."""
    admissible: bool
    """Whether the actuator may be asked for these torques (u_max, bend_max)."""
    tip: tuple[float, float]
    """[m]."""
    angles: list[float]
    """Of the rods (N,) [rad]."""
    S: list[list[float]]
    """Slope of the tip by u (2,2) [m/(N m)], rows x and y."""
    residual: float
    """Largest torque out of balance [N m]."""


def figures(parameters: RigParameters, u: tuple[float, float]) -> Equilibrium:
    """The static pose under the torques u [N m]; ParameterError where gravity topples the actuator."""
    actuator, controller = parameters.actuator, parameters.controller
    with computable(actuator):
        smap = static_map(actuator, controller)
    statics = smap.statics
    scratch = scratch_for(smap)
    tip = static_tip(statics, *u, scratch)
    return Equilibrium(
        actuator=actuator.name,
        rods=controller.rods,
        u=u,
        admissible=bool(admissible(smap.polygon, *u)),
        tip=tip,
        angles=scratch.theta.tolist(),
        S=np.reshape(sensitivity(statics, scratch.theta, *u, scratch), (2, 2)).tolist(),
        residual=float(out_of_balance(statics.body, *u, scratch)),
    )


def described(found: Equilibrium) -> list[str]:
    """The figures in words, in mm, degrees and mN m."""
    beyond = "" if found.admissible else ", torques beyond u_max or bend_max"
    x, y = 1e3 * np.array(found.tip)
    S = found.S
    return [
        f"{found.actuator}, {found.rods} rods{beyond}",
        f"tip: ({x:.3f}, {y:.3f}) mm; last rod at {math.degrees(found.angles[-1]):.2f} degrees",
        f"S: x {S[0][0]:.2f}, {S[0][1]:.2f}; y {S[1][0]:.2f}, {S[1][1]:.2f} mm/(mN m), by u_1 and u_2",
        f"largest torque out of balance: {1e3 * found.residual:.1e} mN m",
    ]
