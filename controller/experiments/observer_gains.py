"""What other gains would give the observer on Task 2's fast runs (paper: K_o = 100 N/m, B_o = 0)."""

from controller.errors import TendrilError
from controller.experiments.case import Case, Setup, run_case
from controller.experiments.metrics import Window
from controller.experiments.results import ObserverGain

RUNS = ("circle_1hz", "vertical_1hz", "horizontal_1hz")
TRIED = ((100.0, 0.0, False), (100.0, 0.0, True), (200.0, 0.0, True), (400.0, 0.0, True), (100.0, 1.0, True))
"""K_o [N/m], B_o [N s/m], and whether a marker is carried on to the present (ours) or held."""


def observer_gains(setup: Setup, seed: int) -> tuple[ObserverGain, ...]:
    """The observer's error at the tip with each of TRIED, P1 under FF+PI."""
    return tuple(tried(setup, seed, *gains) for gains in TRIED)


def tried(setup: Setup, seed: int, K_o: float, B_o: float, carry_on: bool) -> ObserverGain:
    """One choice of gains; nan for a run that the rig broke off."""
    gains = setup.gains.model_copy(update={"K_o": (K_o, K_o), "B_o": (B_o, B_o)})
    changed = Setup(setup.twin, setup.controller.model_copy(update={"carry_on": carry_on}), gains)
    return ObserverGain(K_o, B_o, carry_on, {name: observer_rmse(changed, Case(name, seed=seed)) for name in RUNS})


def observer_rmse(setup: Setup, case: Case) -> float:
    """Observer's tip against the true one over the whole run [mm]."""
    try:
        return run_case(case, setup).metrics[Window.WHOLE]["observer_rmse"]
    except TendrilError:
        return float("nan")
