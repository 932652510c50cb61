"""How often an observer winds: `python -m tests.controller.wound [RUNS]` prints how many of them `reseat` set again.

Arms are dragged about at random under gains up to the page's bounds, with markers that are lost, displaced and noisy,
with every choice of sensors; in half of the runs no watchdog ends a whip.
"""

import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from controller.drivers.twin import inject
from controller.schema.actuator import PRESETS
from controller.schema.fit import TWIN
from controller.schema.messages import TwinFaults
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, TwinParameters
from tests.controller.trial import Trial
from tests.controller.whips import FREE

SENSED = (1 << 9, 1 << 5, 1 << 9 | 1 << 5, (1 << 10) - 1, 1 << 2)
SECONDS, TARGETS = 4.0, 20


def moves(seed: int) -> tuple[str, int]:
    """The actuator of a run, and how often its observer was set again."""
    rng = np.random.default_rng(seed)
    name, free = str(rng.choice(list(PRESETS))), bool(rng.integers(2))
    trial = Trial(
        parameters=RigParameters(
            actuator=PRESETS[name],
            controller=ControllerParameters(observer_kappa=TWIN["kappa"] * float(rng.choice([0.5, 1.0, 1.4]))),
            limits=FREE if free else SafetyLimits(),
            twin=TwinParameters(seed=seed, zeta=float(rng.uniform(0.1, 0.5))),
        ),
        sensed=int(rng.choice(SENSED)),
        K_P=(float(rng.uniform(0.0, 5.0)),) * 2,
        K_I=(float(rng.uniform(0.0, 20.0)),) * 2,
        K_o=(float(rng.choice([100.0, 400.0, 500.0])),) * 2,
    )
    trial.arm()
    loss, noise = float(rng.choice([0.0, 0.3])), float(rng.choice([0.0, 2e-3]))
    for at in rng.uniform((-0.1, -0.2), (0.25, 0.2), (TARGETS, 2)):
        jump = (0.0, float(rng.choice([0.0, 0.0, 0.0, 0.03])))
        inject(TwinFaults(marker_loss=loss, noise=noise, jump=jump), trial.twin.faults)
        rows = trial.follow(float(at[0]), float(at[1]), SECONDS / TARGETS)
    return name, int(rows["reseats"][-1])


def main(runs: int) -> None:
    found: Counter[str] = Counter()
    with ProcessPoolExecutor() as pool:
        for name, made in pool.map(moves, range(runs), chunksize=50):
            found[name] += made > 0
    print(f"{sum(found.values())} of {runs} runs were set again", dict(found))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
