"""Static tests of the Cosserat plant, as a lab would make them, and runs of models on it.

Pressures are held at several co-contractions, and markers read once the body has come to rest.
`python -m tests.controller.foreign` prints what `tendril identify` makes of them, and how far tip and observer are off
on circles with each actuator's own file and with the identified one as the model, on the same plant.
"""

import itertools
import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.cosserat import build_cosserat, rest_of
from controller.kernels.plant.cosserat import Cosserat, drive, stiffen
from controller.reference.library import reference
from controller.research.identification.identify import IdentificationTask, finished, identify
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import RigParameters, SafetyLimits, TwinParameters
from controller.simulation.case import Case, Outcome, Setup, outcome, parameters_of, settings_of
from controller.simulation.metrics import Window
from controller.simulation.run import run

FOREIGN = TwinParameters(plant="cosserat")
SETUP = Setup(twin=FOREIGN)
STRETCH = 0.05
"""By which the pressures of u_max lengthen the bodies, beside the 30 % by which they stiffen them."""
FILES = {
    "P1": PRESETS["P1"].model_copy(update={"u_max": 0.065, "pressure_max": 265e3}),
    "P2": PRESETS["P2"],
    "P3": PRESETS["P3"].model_copy(update={"u_max": 0.1, "pressure_max": 410e3}),
}
"""The paper's; P1 and P3, which stiffening keeps from their circles' ends, with more pressure."""
BODIES = {
    name: file.model_copy(update={"stretching": tuple(STRETCH / (file.u_max * file.pair_slopes))})
    for name, file in FILES.items()
}
"""What is tested and followed on: no file says that pressure lengthens it."""
NOISE = 2e-4
"""Of a marker [m]."""
MARKERS = 10
HELD, OF_ONE, OF_OTHER = (0.0, 0.3, 0.6), (-0.4, 0.0, 0.4), (-0.4, -0.2, 0.0, 0.2, 0.4)
"""Pressures that both chambers of a pair hold, and differences on top, in shares of that of u_max."""
AtRest = Callable[[Array], Array]
"""Markers (10,2) [m] where a body comes to rest under pressures (4,) [Pa]."""
RAMP = 200
"""Ticks in which pressures are brought up, and in which they are then held: many times the pairs' lags."""


class Foreign(NamedTuple):
    """A plant on other mathematics than the model's."""

    at_rest: Callable[[Actuator], AtRest]
    followed: Callable[[Case, Actuator, Actuator], Outcome]
    """Of a case, with a model in observer and controller, on the plant of a body."""


def static_tests(actuator: Actuator, at_rest: AtRest, seed: int = 0) -> str:
    """A table of 45 poses."""
    random, full = np.random.default_rng(seed), actuator.u_max * np.array(actuator.pressure_map)
    lines = [",".join(["p1", "p2", "p3", "p4", *(f"{axis}{i + 1}" for i in range(MARKERS) for axis in "xy")])]
    for held, *u in itertools.product(HELD, OF_ONE, OF_OTHER):
        shares = [held + max(sign * s, 0.0) for s in u for sign in (1.0, -1.0)]
        pressure = np.array(shares) * np.repeat(full, 2)
        points = at_rest(pressure) + random.normal(0.0, NOISE, (MARKERS, 2))
        lines.append(",".join(f"{value:.6g}" for value in (*pressure, *points.ravel())))
    return "\n".join(lines) + "\n"


def cosserat_at_rest(actuator: Actuator) -> AtRest:
    """Of the Cosserat plant of `actuator`."""
    plant = build_cosserat(RigParameters(actuator=actuator, twin=FOREIGN))
    every = plant.every[0]

    def markers(pressure: Array) -> Array:
        press(plant, pressure)
        return np.asarray(rest_of(plant.rod, plant.forces)[:2, every - 1 :: every].T)

    return markers


def press(plant: Cosserat, pressure: Array) -> None:
    """Bring the chambers from none to `pressure` (4,) [Pa], and let what they do to the rod come to rest."""
    pairs, chambers = plant.pairs, plant.chambers
    pairs.difference[:] = pairs.stretched[:] = pairs.torque[:] = 0.0
    for share in np.minimum(np.arange(1, 2 * RAMP) / RAMP, 1.0):
        chambers.pressure[:] = share * pressure
        drive(chambers, pairs)
    stiffen(plant.rod, chambers, pairs, plant.forces)


def identified(actuator: Actuator, folder: Path, at_rest: Callable[[Actuator], AtRest] = cosserat_at_rest) -> Actuator:
    """What `tendril identify` makes of the static tests, under the same name, by which shapes find their place."""
    data = folder / "poses.csv"
    data.write_text(static_tests(actuator, at_rest(actuator)))
    return finished(identify(IdentificationTask((data,), FILES[actuator.name])), folder / f"{actuator.name}.toml")


def followed(case: Case, model: Actuator, body: Actuator) -> Outcome:
    """`case` with `model` in observer and controller, on the Cosserat plant of `body`."""
    path, parameters = reference(case.reference, model, SETUP.controller), known_by(model, case, body, SETUP)
    return outcome(case, path, run(parameters, path, settings_of(case, SETUP.gains), case.seed))


def known_by(model: Actuator, case: Case, body: Actuator, setup: Setup) -> RigParameters:
    """Parameters of `case` with `model` in observer and controller, and the plant of `body`."""
    update = {"actuator": model, "plant_actuator": body, "limits": SafetyLimits(pressure_max=450e3)}
    return parameters_of(case, setup).model_copy(update=update)


COSSERAT = Foreign(cosserat_at_rest, followed)


def backbone_miss(found: Outcome) -> float:
    """RMS distance of the observer's backbone from the true one, after the approach [mm]."""
    rows = found.rows[found.reference.start :]
    off = np.asarray(rows["backbone"], np.float64) - np.asarray(rows["twin_backbone"], np.float64)
    return 1e3 * math.sqrt(float((off**2).sum(axis=-1).mean()))


def report(foreign: Foreign) -> None:
    """Print the figures of docs/model.md."""
    for name, body in BODIES.items():
        with tempfile.TemporaryDirectory() as folder:
            model = identified(body, Path(folder), foreign.at_rest)
        EI = ", ".join(f"{value:.4g}" for value in model.EI or ())
        print(f"{name}: EI {EI} N m^2, stiffening {model.stiffening} /Pa, chambers {model.chamber_arcs} m")
        print(f"  stretching {model.stretching} /Pa, pressure_map {model.pressure_map} Pa/(N m)")
        for shape, law in itertools.product(("circle_0.25hz", "circle_1hz"), ("ff+pi", "rod6")):
            for word, chosen in (("file", FILES[name]), ("identified", model)):
                found = foreign.followed(Case(shape, name, law), chosen, body)
                rmse = found.metrics[Window.WHOLE]["rmse"]
                print(f"  {shape}, {law}, {word}: tip {rmse:.1f}, backbone {backbone_miss(found):.1f} mm")


if __name__ == "__main__":
    report(COSSERAT)
