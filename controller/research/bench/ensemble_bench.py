"""How much of a fit's run is simulated in a second of one core: with the twin of the calibration, and the usual one.

Both are timed in turns by the time that the processor gave them, the best of each: other programs only make it longer.
"""

import time
from typing import TypedDict

from controller.schema.modes import Integrator
from controller.schema.parameters import TwinParameters
from controller.simulation.case import Case, Setup, parameters_of, planned, settings_of
from controller.simulation.run import attempt

CASE = Case("circle_1hz")
"""A fit row that uses all of the loop."""


class EnsembleFigures(TypedDict):
    """Simulated seconds of CASE in a second."""

    seconds_per_second: float
    """With one implicit step of the twin a tick, as in the calibration."""
    rk4_seconds_per_second: float
    """With the twin's usual RK4."""
    implicit_over_rk4: float


def time_ensembles(rounds: int) -> EnsembleFigures:
    """Best of `rounds` whole runs each, from planning's end to the last telemetry row."""
    implicit, rk4 = zip(*((speed(Integrator.IMPLICIT), speed(Integrator.RK4)) for _ in range(rounds)), strict=True)
    ours, usual = max(implicit), max(rk4)
    return EnsembleFigures(seconds_per_second=ours, rk4_seconds_per_second=usual, implicit_over_rk4=ours / usual)


def speed(integrator: Integrator) -> float:
    """Simulated over elapsed time of one run: building and arming the rig take no simulated time."""
    setup = Setup(twin=TwinParameters(integrator=integrator))
    path = planned(CASE.reference, CASE.actuator, setup.controller)
    parameters, settings = parameters_of(CASE, setup), settings_of(CASE, setup.gains)
    begin = time.process_time()
    rows = attempt(parameters, path, settings, CASE.seed)
    return len(rows) * setup.controller.dt / (time.process_time() - begin)
