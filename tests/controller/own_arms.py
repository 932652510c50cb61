"""Arms as labs have them, drawn at random: whether each one's twin is that arm.

`python -m tests.controller.own_arms [COUNT]` prints how many of 1000 are built and run, why the others are refused,
and how far the first mode that is simulated is from the file's; a minute of a core.
"""

import math
import re
import sys
from collections import Counter
from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from controller.assembly.rod import build_rod
from controller.assembly.stability import move, slowest, small_motions
from controller.assembly.twin import build_twin
from controller.errors import ParameterError, sentence
from controller.kernels.model.implicit import implicit_step
from controller.kernels.plant.twin import Twin
from controller.schema.actuator import Actuator
from controller.schema.parameters import RigParameters
from controller.simulation.acceptance import require_running

COUNT = 1000
LENGTH, MASS, FREQUENCY, ZETA = (0.05, 1.0), (0.005, 2.0), (0.3, 15.0), (0.02, 0.6)
"""Between these [m, kg, Hz, 1], evenly in their logarithms."""
RODS = (2, 40)
TAPER = (0.3, 1.0)
"""Stiffness, and mass per length, at the tip over that at the base."""
GRAVITIES = ((0.0, 0.0), (9.81, 0.0), (0.0, -9.81), (-9.81, 0.0))
"""Lying, hanging, held out, standing."""
BEND = (0.5, 2.0)
"""Of the tip under both pairs' u_max [rad]."""
PRESSURE = 2e5
"""That u_max takes [Pa]."""
SWING = 1e-4
"""Of the arm that is let go [rad]."""
PERIODS = 3.0
NUMBER = r"-?\d[\d.]*(e[+-]?\d+)?"


class Found(NamedTuple):
    """What became of one arm."""

    refused: str
    """Why, "" where it runs."""
    frequency: float = 1.0
    """Of the simulated first mode over the file's, undamped."""
    zeta: float = 1.0
    """Its damping ratio over the file's."""


def arm(seed: int) -> Actuator:
    """An arm drawn at random; ParameterError, or pydantic's, where a file could not say it."""
    draw = np.random.default_rng(seed)
    length, mass, frequency, zeta = (
        float(np.exp(draw.uniform(*np.log(bounds)))) for bounds in (LENGTH, MASS, FREQUENCY, ZETA)
    )
    rods = int(draw.integers(RODS[0], RODS[1] + 1))
    taper, lighter = draw.uniform(*TAPER, 2)
    half = max(1, rods // 2)
    base = {
        "name": f"arm {seed}",
        "length": length,
        "mass": mass,
        "table_rods": rods,
        "mass_profile": (1.0, lighter),
        "chambers": ((0, half), (half, rods)),
        "alpha": 0.0,
    }
    loose = build_rod(Actuator(**base, k=(1.0, taper), b=(0.0,)), rods)
    omega = math.tau * frequency
    k = (omega / slowest(loose)[0]) ** 2 * np.array([1.0, taper])
    turned = float(np.sum(1.0 / np.interp(np.linspace(0, 1, rods), (0, 1), k)))
    u_max = min(max(draw.uniform(*BEND) / turned, 1e-4), 0.2)
    return Actuator(
        **base
        | {"k": tuple(k), "b": tuple(zeta / omega * k), "alpha": min(zeta * omega, 50.0), "u_max": u_max}
        | {"pressure_map": (min(PRESSURE / u_max, 1e9),) * 2, "gravity": GRAVITIES[draw.integers(len(GRAVITIES))]}
    )


def simulated(twin: Twin, dt: float) -> tuple[float, float]:
    """The same of the twin as it is stepped, let go in its first mode."""
    n, rest = twin.model.rest.size, twin.model.rest
    values, right = np.linalg.eig(small_motions(twin.model, rest))
    at = int(np.argmin(np.abs(values)))
    left = np.linalg.inv(right)[at]
    move(twin.model, rest, SWING * (right[:, at] / np.abs(right[:n, at]).max()).real, twin.state)
    ticks = max(20, round(PERIODS * math.tau / abs(values[at]) / dt))
    seen = np.zeros(ticks + 1, complex)
    for i in range(ticks + 1):
        seen[i] = left @ np.concatenate([twin.state.q[2] - rest, twin.state.v[2]])
        implicit_step(twin.creeping, twin.load, dt, twin.state, twin.implicit_work)
    t = dt * np.arange(ticks + 1)
    decay, turn = (np.polyfit(t, part, 1)[0] for part in (np.log(np.abs(seen)), np.unwrap(np.angle(seen))))
    return math.hypot(decay, turn), -decay / math.hypot(decay, turn)


def checked(seed: int) -> Found:
    """Build the arm's rig, run it, and let its twin go."""
    try:
        parameters = RigParameters(actuator=arm(seed))
        require_running(parameters)
        twin = build_twin(parameters)
    except ValidationError as error:
        return Found(sentence(error))
    except ParameterError as error:
        return Found(str(error))
    omega, zeta = slowest(build_rod(parameters.actuator, parameters.actuator.table_rods))
    omega_seen, zeta_seen = simulated(twin, parameters.controller.dt)
    return Found("", omega_seen / omega, zeta_seen / zeta)


def main() -> None:
    """Print the figures."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    found = [checked(seed) for seed in range(count)]
    ran = [one for one in found if not one.refused]
    print(f"{len(ran)} of {count} arms are built and run")
    reasons = Counter(re.sub(NUMBER, "#", one.refused) for one in found if one.refused)
    for why, times in reasons.most_common():
        print(f"  {times} refused: {why}")
    for name in ("frequency", "zeta"):
        off = sorted(abs(getattr(one, name) - 1.0) for one in ran)
        print(f"{name}: off the file's by {100 * off[len(off) // 2]:.2f} % (median), {100 * off[-1]:.2f} % (most)")


if __name__ == "__main__":
    main()
