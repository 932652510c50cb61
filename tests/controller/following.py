"""A target clicked and dragged anywhere, in reach or not, on plants of a family: what stops the rig, and what swings.

`python -m tests.controller.following` makes 500 clicks and 500 drags of each actuator, with each choice of sensors, on
each plant: 486,000 in all, some four and a half hours of a core; `... 100 "rod 3" tip` 100 of each with those sensors,
`... --observer-kappa 1` with the table's inertia in every observer, not as `tendril up` begins, `... --controller
preview` with that in the slot. What came so far is printed after each 50.
"""

import argparse
import itertools
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np

from controller.arrays import Rows
from controller.assembly.controllers.registry import with_controller
from controller.assembly.statics import static_map
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.fit import TWIN
from controller.schema.modes import Cause, Law, Mode, Request
from controller.schema.parameters import (
    ControllerParameters,
    Integrator,
    RigParameters,
    Settings,
    TwinParameters,
    usual_kappa,
)
from tests.controller.trial import Trial, true_tip

SENSED = {
    "tip": 1 << 9,
    "rods 6 and 10": 1 << 5 | 1 << 9,
    "all": 1023,
    **{f"rod {n}": 1 << (n - 1) for n in (6, 5, 4, 3, 2, 1)},
}
FAMILY = tuple(itertools.product((0.1, 0.352, 0.5), (0.04, 0.05, 0.07)))
"""Damping ratios, and dead times [s]."""
BENT_ALREADY = PRESETS["P3"].model_copy(update={"name": "bent already", "rest_curvature": (6.0,)})
SAGGING = PRESETS["P2"].model_copy(update={"name": "sagging", "gravity": (0.0, -4.0)})
LOADED = PRESETS["P1"].model_copy(update={"name": "loaded", "gravity": (4.0, 0.0), "tip_load": 0.004})
ACTUATORS = {**PRESETS, **{one.name: one for one in (BENT_ALREADY, SAGGING, LOADED)}}
MARGIN = 0.03
"""Targets lie up to this far outside the box about the reach [m]."""
STILL, LATE = 3.0, 0.8
"""After how long a wait the arm must not swing, and for how long that is looked at [s]."""
SWING = 5e-3
"""What of the tip's last motion is no even drift, up to which it counts as still [m]."""
PART = 50
"""Moves of one course."""


class Course(NamedTuple):
    """What is done with the target, on what."""

    actuator: str
    sensed: str
    zeta: float
    dead_time: float
    dragged: bool
    seed: int = 0
    observer_kappa: float = 1.0
    controller: str = "paper"


class Came(NamedTuple):
    """What came of it."""

    stops: list[str]
    """Cause and target of each stop."""
    swings: list[str]
    """Amplitude and target where the arm still swung."""


def parameters(course: Course) -> RigParameters:
    """The plant has what was fitted to the paper, P1 in a pull as well."""
    swings = {"zeta": course.zeta, "dead_time": course.dead_time, "seed": course.seed}
    twin = TwinParameters.model_validate(TWIN | swings)
    controller = ControllerParameters(observer_kappa=course.observer_kappa)
    return RigParameters(actuator=ACTUATORS[course.actuator], controller=controller, twin=twin)


def came_of(course: Course, count: int, patient: bool = False) -> Came:
    """`count` clicks or drags one after the other; after a stop the rig begins again.

    `patient`: an arm that still swings after STILL is given as long again.
    """
    random, came, goal = np.random.default_rng(course.seed), Came([], []), np.array([0.0, 0.0])
    rig, sensed = parameters(course), SENSED[course.sensed]
    trial = fresh(rig, sensed, controller=course.controller)
    for _ in range(count):
        path = list(way(course, goal, random))
        goal = path[-1]
        rows = trial.drag([(float(x), float(y)) for x, y in path], 0.016 * len(path))
        if random.random() < 0.5:
            rows = np.concatenate([rows, trial.run(round(1000 * (STILL + LATE)))])
        else:
            rows = np.concatenate([rows, trial.run(round(1000 * random.uniform(0.2, 1.5)))])
        where = np.round(1e3 * goal).astype(int).tolist()
        stopped = np.flatnonzero(rows["mode"] != Mode.FOLLOW)
        if stopped.size:
            came.stops.append(f"{Cause(rows['cause'][stopped[0]]).name} at {where} mm")
            trial = fresh(rig, sensed, controller=course.controller)
        elif (left := swing(rows)) > SWING and (not patient or (left := swing(trial.run(round(1000 * STILL)))) > SWING):
            came.swings.append(f"{1e3 * left:.0f} mm at {where} mm")
    return came


def fresh(rig: RigParameters, sensed: int, law: Law = Law.FF_PI, controller: str = "paper") -> Trial:
    """Armed, and following the tip at rest, by the sensors `sensed` (as bits)."""
    chosen = with_controller(Settings(), controller)
    trial = Trial(parameters=rig, sensed=sensed, law=law, controller=chosen.controller, tuning=chosen.tuning)
    trial.arm()
    x, y = trial.run(1)["p_ref"][-1]
    trial.ask(Request.FOLLOW, (float(x), float(y)), 200)
    return trial


def way(course: Course, begin: np.ndarray, random: np.random.Generator) -> Iterator[np.ndarray]:
    """Points (2,) [m], one each 16 ms: a new target at once, or a line of one to three of them."""
    for _ in range(random.integers(1, 4) if course.dragged else 1):
        end = target(ACTUATORS[course.actuator], random)
        steps = max(1, int(np.linalg.norm(end - begin) / random.uniform(0.1, 1.0) / 0.016)) if course.dragged else 1
        yield from begin + (end - begin) * np.arange(1, steps + 1)[:, None] / steps
        begin = end


def target(actuator: Actuator, random: np.random.Generator) -> np.ndarray:
    """Anywhere: every other one a point of the reach."""
    tips = static_map(actuator, RigParameters().controller).seed_tips
    if random.random() < 0.5:
        return np.asarray(tips[random.integers(len(tips))])
    return random.uniform(tips.min(axis=0) - MARGIN, tips.max(axis=0) + MARGIN)


def swing(rows: Rows) -> float:
    """How far the tip still swung about an even drift [m]; 0 where the reference did not stand still for long."""
    late = rows[-round(1000 * LATE) :]
    waited = rows["p_ref"][-round(1000 * STILL) :]
    if len(waited) < 1000 * STILL or np.ptp(waited, axis=0).max() > 1e-3:
        return 0.0
    tip, t = true_tip(late), np.arange(len(late)) - 0.5 * (len(late) - 1)
    return float(np.ptp(tip - np.outer(t, t @ tip / (t @ t)), axis=0).max())


def _one(job: tuple[Course, int]) -> tuple[Course, Came]:
    return job[0], came_of(*job, patient=True)  # what dies out late is no limit cycle


def measure(count: int, choices: list[str], observer_kappa: float | None, controller: str) -> None:
    """`count` clicks and `count` drags of each actuator with each of the choices of sensors on each plant."""
    total = {pair: np.zeros(3, int) for pair in itertools.product(ACTUATORS, choices)}
    with ProcessPoolExecutor() as pool:
        for part in range(-(-count // PART)):
            each = min(PART, count - part * PART)
            todo = courses(part, choices, observer_kappa, controller)
            for course, came in pool.map(_one, ((course, each) for course in todo)):
                total[course.actuator, course.sensed] += (each, len(came.stops), len(came.swings))
                if came.stops or came.swings:
                    print(course, *came.stops, *came.swings, flush=True)
            print("actuator, sensed: clicks and drags, stops, swings")
            for (name, sensed), row in total.items():
                print(f"{name}, {sensed}:", *row, flush=True)


def courses(part: int, choices: list[str], observer_kappa: float | None, controller: str) -> Iterator[Course]:
    """Of each combination one that no other part has."""
    for name, sensed, dragged in itertools.product(ACTUATORS, choices, (False, True)):
        kappa = observer_kappa or usual_kappa(ACTUATORS[name], Integrator.IMPLICIT)
        for n, plant in enumerate(FAMILY):
            yield Course(name, sensed, *plant, dragged, part * len(FAMILY) + n, kappa, controller)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int, nargs="?", default=500)
    parser.add_argument("choices", nargs="*", default=list(SENSED))
    parser.add_argument("--observer-kappa", type=float)
    parser.add_argument("--controller", default="paper")
    measure(**vars(parser.parse_args()))
