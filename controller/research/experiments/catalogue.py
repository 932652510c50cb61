"""Which runs make up a reproduction of the paper, in its order."""

from controller.reference.library import SWEEP
from controller.research.experiments.paper_rows import DIGITS, SENSING, SENSING_LAWS, STEP_LAWS
from controller.simulation.case import Case

SEEDS, SENSING_SEEDS = 3, 5
"""Runs of every case; of Task 4 as many as in the paper."""
LIVE_PATH = "live_path"

CASES: tuple[Case, ...] = (
    *(Case("step", law=law) for law in STEP_LAWS),
    *(Case(name) for name in DIGITS),
    *(Case("vu", actuator) for actuator in ("P1", "P2", "P3")),
    *(Case(f"{line}_{f}hz") for line in ("vertical", "horizontal") for f in ("0.25", "1")),
    Case("circle_0.25hz"),
    *(Case("circle_1hz", actuator) for actuator in ("P1", "P2", "P3")),
    Case("circle_2hz", "P3"),
    *(Case(name, law=law) for name in SENSING for law in SENSING_LAWS),
    Case(LIVE_PATH),
    *(Case(name) for name in SWEEP),
)
"""Each once; Task 3's P2 and P3 change nothing but the model's parameters."""


def catalogue(seed: int = 0, quick: bool = False) -> tuple[Case, ...]:
    """Every run of a reproduction, a case's runs side by side, with seeds from `seed` on; `quick` runs each once."""
    return tuple(
        Case(case.reference, case.actuator, case.law, one) for case in CASES for one in seeds(case, seed, quick)
    )


def seeds(case: Case, seed: int, quick: bool) -> tuple[int, ...]:
    """Seeds of the runs of `case`."""
    count = 1 if quick else SENSING_SEEDS if case.reference in SENSING else SEEDS
    return tuple(range(seed, seed + count))
