"""What few markers cost: the observer's estimate, and the arm that it corrects, dragged about and on planned paths.

`python -m tests.controller.few_markers` prints the three tables of docs/observer.md, in a quarter of an hour of a core.
"""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from controller.errors import TendrilError
from controller.schema.modes import Law, Mode
from controller.schema.parameters import SENSORS, ControllerParameters, PlantKind, RigParameters, TwinParameters
from controller.simulation.case import Case, Setup, run_case
from controller.simulation.metrics import Window
from controller.text.markdown import table
from tests.controller.following import FAMILY, Course, fresh, parameters, way
from tests.controller.trial import true_tip

NAMES = ("P1", "P2")
RODS = (0, 1, 2, 3, 4, 5, 6, SENSORS)
SHARES = (0.5, 1.0, 1.4)
"""Of the plant's kappa what the observer is told; 1.4 is what a measurement finds, with creep and hysteresis in it."""
PLANTS: tuple[PlantKind, ...] = ("rod", "cosserat")
PATHS = ("circle_1hz", "circle_0.25hz", "vu")
FIRST = 72
"""Seed of the first course."""
DRAGS, SHORT = 50, 25


class Came(NamedTuple):
    """What came of some drags."""

    estimate: float
    """Mean square of the estimated tip's distance from the true one [m^2]."""
    error: float
    """Of the true tip's from the reference [m^2]."""
    swing: float
    """Most of the estimated error's mean square about its mean over `error_rms_time`, which TRACKING_RMS looks at."""
    off: float
    """Longest time that the estimated error was above its limit, less that below it [s]."""
    stops: int


def dragged(rig: RigParameters, course: Course, sensed: int, law: Law, drags: int) -> Came:
    """Drags one after the other, half of them with a rest; after a stop the rig begins again."""
    random, goal = np.random.default_rng(course.seed), np.zeros(2)
    trial, came = fresh(rig, sensed, law), []
    for _ in range(drags):
        path = list(way(course, goal, random))
        goal, swing, off, rows = path[-1], 0.0, 0.0, []
        for x, y in path:
            rows.append(trial.drag([(float(x), float(y))], 0.016))
            state = trial.rig.control.state[0]
            swing = max(swing, state["error_square"] - (state["error_mean"] ** 2).sum() - state["error_first"])
            off = max(off, state["off_time"])
        rows.append(trial.run(3800 if random.random() < 0.5 else round(1000 * random.uniform(0.2, 1.5))))
        every = np.concatenate(rows)
        stopped = bool((every["mode"] != Mode.FOLLOW).any())
        tip = true_tip(every)
        apart = (float(((every[name] - tip) ** 2).sum(axis=1).mean()) for name in ("p_hat", "p_ref"))
        came.append(Came(*apart, swing, off, int(stopped)))
        if stopped:
            trial = fresh(rig, sensed, law)
    return _together(came)


def _together(came: list[Came]) -> Came:
    means, most = np.mean(came, axis=0), np.max(came, axis=0)
    return Came(means[0], means[1], most[2], most[3], sum(one.stops for one in came))


def estimated(job: tuple[int, str, float]) -> float:
    """Rms distance [mm] of estimated and true tip under feedforward alone, of sensed rod, actuator, observer_kappa."""
    (rods, name, kappa), came = job, []
    for seed, plant in enumerate(FAMILY[1::3], FIRST):
        course = Course(name, "tip", *plant, dragged=True, seed=seed, observer_kappa=kappa)
        came.append(dragged(parameters(course), course, _bits(rods), Law.FF, SHORT))
    return 1e3 * float(np.sqrt(np.mean([one.estimate for one in came])))


def corrected(name: str, rods: int, observer_kappa: float, full_gains_from: float) -> Came:
    """As it comes under FF + PI on all plants of the family."""
    came = []
    for seed, plant in enumerate(FAMILY, FIRST):
        course = Course(name, "tip", *plant, dragged=True, seed=seed)
        controller = ControllerParameters(observer_kappa=observer_kappa, full_gains_from=full_gains_from)
        rig = parameters(course).model_copy(update={"controller": controller})
        came.append(dragged(rig, course, _bits(rods), Law.FF_PI, DRAGS))
    return _together(came)


def _bits(rods: int) -> int:
    return 1 << rods >> 1


def measure() -> None:
    """Print the tables."""
    with ProcessPoolExecutor() as pool:
        print_estimates(pool)
        print_paths(pool)
        print_corrections(pool)


def print_estimates(pool: ProcessPoolExecutor) -> None:
    """By sensed rod, actuator and the observer's kappa."""
    kappas = (1.0, *(share * TwinParameters().kappa for share in SHARES))
    jobs = list(product(RODS, NAMES, kappas))
    found = dict(zip(jobs, pool.map(estimated, jobs), strict=True))
    head = ["sensed", *(f"{name}, {kappa:.0f}" for name, kappa in product(NAMES, kappas))]
    rows = [[_said(rods), *(f"{found[rods, *one]:.1f}" for one in product(NAMES, kappas))] for rods in RODS]
    print(table(head, rows), flush=True)


def planned(job: tuple[PlantKind, str, str, float]) -> str:
    """Rms distance [mm] of estimated and true tip, and of that from the path, by rod 6: of plant, path, name, kappa."""
    plant, path, name, kappa = job
    setup = Setup(TwinParameters(plant=plant), ControllerParameters(observer_kappa=kappa))
    try:
        found = run_case(Case(path, name, "rod6"), setup).metrics[Window.WHOLE]
    except TendrilError as error:
        return str(error).split(", instead", 1)[0]
    return f"{found['observer_rmse']:.1f}, {found['rmse']:.1f}"


def print_paths(pool: ProcessPoolExecutor) -> None:
    """By rod 6 under FF + PI, on both plants, by the table's inertia and by the twin's."""
    kappas = {"the table's": 1.0, "the twin's": TwinParameters().kappa}
    jobs = list(product(PLANTS, PATHS, NAMES, kappas.values()))
    found = dict(zip(jobs, pool.map(planned, jobs), strict=True))
    head = ["plant, path", *(f"{name}, {whose}" for name, whose in product(NAMES, kappas))]
    rows = [
        [f"{plant}, {path}", *(found[plant, path, *one] for one in product(NAMES, kappas.values()))]
        for plant, path in product(PLANTS, PATHS)
    ]
    print(table(head, rows), flush=True)


def print_corrections(pool: ProcessPoolExecutor) -> None:
    """With gains in full and as the marker tells of the tip: by the table's inertia, then by the plant's."""
    print("| sensed | tip's rms error, mm | swing, mm | longest above 80 mm, s | stops |")
    print("|---" * 5 + "|")
    laws = list(product((1.0, TwinParameters().kappa), (0.0, ControllerParameters().full_gains_from)))
    for name, rods in product(NAMES, range(1, 6)):
        came = list(pool.map(partial(corrected, name, rods), *zip(*laws, strict=True)))
        cells = (
            [f"{1e3 * one.error**0.5:.1f}" for one in came],
            [f"{1e3 * one.swing**0.5:.0f}" for one in came],
            [f"{one.off:.1f}" for one in came],
            [f"{one.stops}" for one in came],
        )
        print(f"| {name}, {_said(rods)} | " + " | ".join(", ".join(cell) for cell in cells) + " |", flush=True)


def _said(rods: int) -> str:
    return {0: "none", SENSORS: "tip"}.get(rods, f"rod {rods}")


if __name__ == "__main__":
    measure()
