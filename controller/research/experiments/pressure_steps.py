"""How the twin's chambers answer a step of their setpoint (paper, supplementary pressure characterisation)."""

import math
from itertools import pairwise

import numpy as np
from numba import njit

from controller.arrays import Array
from controller.assembly.stages import step_of
from controller.assembly.twin import build_twin
from controller.kernels.function_pointer import call
from controller.research.experiments.results import PressureStep
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Measurement, Telemetry
from controller.schema.parameters import DT, RigParameters
from controller.simulation.simulate import START_NS

SETPOINTS = (0.0, 60e3, 0.0, 120e3, 60e3, 80e3, 60e3)
"""Gauge pressures asked of one chamber in turn [Pa] (ours; the paper gives none): of the size that the tasks need."""
HOLD = 1.5
"""How long each is asked for [s]."""
STARTED, MOST = 0.02, 1.0 - math.exp(-1.0)
"""Shares of a step: where the dead time ends, and where a first-order lag is after its time constant."""


def pressure_steps(parameters: RigParameters) -> tuple[PressureStep, ...]:
    """Each step from one of SETPOINTS to the next, with its dead time and its lag."""
    ticks = round(HOLD / DT)
    pressure = driven_pressure(parameters, np.repeat(SETPOINTS, ticks)).reshape(len(SETPOINTS), ticks)
    return tuple(
        measured(begin, end, answer) for (begin, end), answer in zip(pairwise(SETPOINTS), pressure[1:], strict=True)
    )


def measured(begin: float, end: float, pressure: Array) -> PressureStep:
    """The step from `begin` to `end` [Pa] at the first row of `pressure` (n,) [Pa], ticks of DT.

    Its share that is done counts from where the chamber really was.
    """
    done = (pressure - pressure[0]) / (end - pressure[0])
    dead_time, most = first(done >= STARTED), first(done >= MOST)
    t = DT * np.arange(len(pressure), dtype=np.float64)
    return PressureStep(begin, end, t, pressure, dead_time, most - dead_time)


def first(found: np.ndarray) -> float:
    """Time [s] of the first true tick of `found` (n,); nan if there is none."""
    return DT * int(found.argmax()) if found.any() else math.nan


def driven_pressure(parameters: RigParameters, setpoints: Array) -> Array:
    """Pressure (n,) [Pa] of the twin's first chamber at the ticks at which it is asked for `setpoints` (n,) [Pa]."""
    asked = np.zeros(1, record_dtype(Telemetry))
    pressure = np.empty(len(setpoints))
    twin = build_twin(parameters)
    _drive(twin, step_of(twin), (asked, to_record(Measurement())), setpoints, pressure)
    return pressure


@njit(cache=True, nogil=True, error_model="numpy")
def _drive(twin, step, records, setpoints, pressure):  # type: ignore[no-untyped-def]
    """The twin alone, its first chamber asked for one of `setpoints` a tick; `pressure` is that before the tick."""
    asked, measurement = records[0][0], records[1][0]
    for n in range(setpoints.size):
        pressure[n] = measurement.pressures[0]
        asked.pressure_cmd[0] = setpoints[n]
        call(step, (START_NS + n * 1_000_000, twin, asked, measurement))
