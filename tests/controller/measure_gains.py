"""`python -m tests.controller.measure_gains [seeds]`: hard gains in every mode, and all that must not be stopped.

Prints how long after a whip's beginning the rig was in REST, what was not, and each calm run that was stopped.
"""

import itertools
import multiprocessing
import sys
from collections.abc import Iterator

import numpy as np

from controller.research.experiments.campaign import run_one
from controller.research.experiments.catalogue import catalogue
from controller.research.experiments.results import Failure
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import SafetyLimits
from controller.simulation.case import Setup
from tests.controller.calm import Drag, drag, drags, quick_drags
from tests.controller.whips import FREE, NAMED, RUNS, Gains, Judged, broken, judged, onset

K_P = (0.3, 0.6, 1.0, 2.0, 3.0, 5.0)
K_I = (0.0, 2.0, 5.0, 10.0, 20.0)
OTHERS = (
    (("K_o", (500.0, 500.0)),),
    (("K_o", (500.0, 500.0)), ("B_o", (5.0, 5.0))),
    (("K_o", (20.0, 20.0)),),
    (("sensed", 1 << 5),),
    (("sensed", 1023),),
)


def grid(seeds: range) -> Iterator[Gains]:
    for actuator, seed in itertools.product(("P1", "P2", "P3"), seeds):
        for K_p, K_i in itertools.product(K_P, K_I):
            yield Gains(actuator, K_p, K_i, seed=seed)
        for others in OTHERS:
            yield Gains(actuator, 0.3, 20.0, seed=seed, others=others)
            yield Gains(actuator, 5.0, 2.0, seed=seed, others=others)
        for K_FF in (0.1, 0.3, 1.0):
            yield Gains(actuator, 0.3, 2.0, K_FF, seed)


def hard(job: tuple[str, Gains]) -> tuple[str, Gains, Judged]:
    return *job, judged(RUNS[job[0]], job[1])


def stopped(how: Drag) -> tuple[Drag, str, bool]:
    """Why the rig stopped a drag, "" if it did not; whether the arm whipped."""
    rows = drag(how, SafetyLimits())
    if (tick := broken(rows)) is None:
        return how, "", False
    text = f"{Mode(rows['mode'][tick]).name} {Cause(rows['cause'][tick]).name} at {tick} ms"
    return how, text, onset(drag(how, FREE)) is not None


def measure(seeds: range) -> None:
    with multiprocessing.Pool() as pool:
        show_hard(pool.map(hard, itertools.product(RUNS, grid(seeds)), chunksize=4))
        ran = pool.starmap(run_one, [(case, Setup()) for case in catalogue(0, len(seeds) < 3)], chunksize=2)
        failed = [run for run in ran if isinstance(run, Failure)]
        print(f"the paper's runs: {len(ran)}, stopped: {len(failed)}", *failed, sep="\n  ")
        for name, of in (("at the page's first limits", drags), ("at the highest limits", quick_drags)):
            found = pool.map(stopped, of(seeds), chunksize=4)
            wrong = [one for one in found if one[1] and not one[2]]
            whips = sum(one[2] for one in found)
            print(f"drags {name}: {len(found)}, stopped for a whip: {whips}, for none: {len(wrong)}")
            print(*wrong, sep="\n")


def show_hard(runs: list[tuple[str, Gains, Judged]]) -> None:
    for mode in RUNS:
        of = [(gains, one) for name, gains, one in runs if name == mode]
        whips = [(gains, one) for gains, one in of if one.onset is not None]
        late = [pair for pair in whips if delay(pair[1]) > 1000.0 or pair[1].cause not in NAMED]
        found = np.array([delay(one) for _, one in whips if one.reaction is not None])
        worst = max((one.worst for _, one in of), default=0.0)
        spread = "p50 {:.0f}, p95 {:.0f}, max {:.0f} ms".format(*np.percentile(found, [50, 95, 100]))
        print(f"{mode}: {len(of)} runs, {len(whips)} whip; REST after {spread}; largest error {1e3 * worst:.0f} mm")
        for gains, one in late:
            print("  not in time or not named:", gains, one)
        other = [(gains, one) for gains, one in of if one.reaction is not None and one.cause not in NAMED]
        print("  other causes first:", len(other), *other[:10], sep="\n    ")


def delay(one: Judged) -> float:
    return np.inf if one.reaction is None or one.onset is None else one.reaction - one.onset


if __name__ == "__main__":
    measure(range(int(sys.argv[1]) if len(sys.argv) > 1 else 2))
