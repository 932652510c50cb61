"""One run of an experiment as data, and what comes of it."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from controller.arrays import Rows
from controller.assembly.controllers.registry import with_controller
from controller.errors import DataError
from controller.reference.library import reference
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.modes import Integrator, Law
from controller.schema.parameters import REPEATING, ControllerParameters, RigParameters, Settings, TwinParameters
from controller.simulation.metrics import Window, measure
from controller.simulation.run import run

LAWS = {"ff": Law.FF, "ff+p": Law.FF_P, "ff+i": Law.FF_I, "ff+pi": Law.FF_PI}
LETTER = "paper"
"""FF+PI by the paper's equations to the letter, where ours differ."""
BY_THE_LETTER: dict[str, Any] = {
    "weak_ratio": 0.0,
    "weak_ratio_live": 0.0,
    "carry_on": False,
    "measured_torques": False,
    "feedback_lag": 0.0,
    "full_gains_from": 0.0,
    "observer_beta": 0.0,
    "observer_kappa": 1.0,
    "integrator": Integrator.RK4,
}
"""What of ControllerParameters that changes: feedback that never fades, a held marker, believed pressures, undamped
hinges, the table's inertia, ode4."""
SPRINGS: dict[str, Any] = {"K_o": (100.0, 100.0), "B_o": (0.0, 0.0)}
"""What of Settings the paper's observer has (paper, "Dynamic observer")."""
FITTED = ControllerParameters(predict=False, measured_torques=False)
"""The controller with which the twin was fitted to the paper: of a marker's motion and of the pressures its observer
knows what the paper's does, or little more."""
FITTED_GAINS = with_controller(REPEATING.model_copy(update=SPRINGS), "letter")
"""With the integral that S turns into torque, as in the paper: what is looked for is the plant that it ran on."""
SENSED = {"rod6": 1 << 5, "rod10": 1 << 9, "rod6+10": 1 << 5 | 1 << 9}
"""Task 4's choices of sensors, as bits of `Settings.sensed`; all under FF+PI."""


@dataclass(frozen=True)
class Case:
    """A reference of the library on an actuator, under a law or (Task 4) a choice of sensors, with a seed."""

    reference: str
    actuator: str = "P1"
    law: str = "ff+pi"
    seed: int = 0


@dataclass(frozen=True)
class Setup:
    """What all runs of a reproduction share: the plant, the controller's numbers, one set of gains."""

    twin: TwinParameters = field(default_factory=TwinParameters)
    controller: ControllerParameters = FITTED
    gains: Settings = FITTED_GAINS


@dataclass(frozen=True)
class Outcome:
    """A run that came to its end."""

    case: Case
    reference: Reference
    rows: Rows
    """Telemetry (n,), one row a tick of the reference."""
    metrics: dict[Window, dict[str, float]]


def run_case(case: Case, setup: Setup) -> Outcome:
    """Run `case` on `setup`. The same case on the same setup gives the same bits.

    Raises DataError for an unknown law and TendrilError if the rig does not follow to the end.
    """
    path = planned(case.reference, case.actuator, setup.controller)
    rows = run(parameters_of(case, setup), path, settings_of(case, setup.gains), case.seed)
    return outcome(case, path, rows)


@lru_cache(maxsize=64)
def planned(name: str, actuator: str, controller: ControllerParameters) -> Reference:
    """`reference`, planned once a process: neither plant, gains nor seed change it."""
    return reference(name, PRESETS[actuator], controller)


def outcome(case: Case, planned: Reference, rows: Rows) -> Outcome:
    """The run `rows` (n,) of `planned`, with its metrics in both windows."""
    return Outcome(case, planned, rows, {window: measure(rows, planned, window) for window in Window})


def parameters_of(case: Case, setup: Setup) -> RigParameters:
    """What the rig of `case` is started with; the seed of the twin is the run's."""
    twin = setup.twin.model_copy(update={"seed": case.seed})
    controller = controller_of(case.law, setup.controller)
    return RigParameters(actuator=PRESETS[case.actuator], controller=controller, twin=twin)


def controller_of(law: str, controller: ControllerParameters) -> ControllerParameters:
    """`controller`, to the paper's letter where `law` asks for it."""
    return controller.model_copy(update=BY_THE_LETTER) if law == LETTER else controller


def settings_of(case: Case, gains: Settings) -> Settings:
    """`gains` under the law and sensors of `case`."""
    if case.law not in (known := (*LAWS, *SENSED, LETTER)):
        raise DataError(f"law = {case.law!r} is none of {', '.join(known)}")
    law, springs = LAWS.get(case.law, Law.FF_PI), SPRINGS if case.law == LETTER else {}
    gains = with_controller(gains, "letter") if case.law == LETTER else gains
    return gains.model_copy(update={"law": law, "sensed": SENSED.get(case.law, gains.sensed)} | springs)
