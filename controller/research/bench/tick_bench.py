"""The closed loop with its twin, as fast as it goes: armed, following a moving target; and how long its ticks take."""

import time
from typing import NamedTuple

import numpy as np

from controller.arrays import Words
from controller.assembly.rig import build_rig
from controller.assembly.stages import Stages, stages_of
from controller.assembly.twin import build_twin
from controller.errors import TendrilError
from controller.kernels.control.tick import Rig
from controller.kernels.function_pointer import call
from controller.kernels.plant.twin import Twin
from controller.realtime.clock import now_ns
from controller.realtime.compiled import compiled
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters

CENTRE, RADIUS, TURN = (0.03, 0.14), 0.03, 0.5
"""The target's circle: centre and radius [m], turns per second."""
BOOT = 1
ARMING = 500
"""Ticks for each step of arming."""


class Inputs(NamedTuple):
    """What the loop hands to a tick, each an array of one record."""

    command: np.ndarray
    measurement: np.ndarray
    status: np.ndarray


@compiled
def run_ticks(rig: Rig, twin: Twin, stages: Stages, inputs: Inputs, telemetry: np.ndarray, spans: Words) -> None:
    """Tick and step the twin once for every entry of `spans` (n,), which becomes the tick's duration [ns].

    A perfect loop on a clock that goes on from the last tick in `telemetry`, one record.
    """
    clock = np.zeros(4, np.int64)
    command, measurement, status, row = inputs.command[0], inputs.measurement[0], inputs.status[0], telemetry[0]
    period_ns = round(rig.control.dt * 1e9)
    for i in range(spans.size):
        t_ns = row.t_ns + period_ns
        angle = 2 * np.pi * TURN * 1e-9 * t_ns
        command.target[0] = CENTRE[0] + RADIUS * np.cos(angle)
        command.target[1] = CENTRE[1] + RADIUS * np.sin(angle)
        command.presence += 1
        status.server_ns = status.pump_ns = t_ns
        start_ns = now_ns(clock)
        call(stages.tick, (t_ns, command, measurement, status, rig, row))
        spans[i] = now_ns(clock) - start_ns
        call(stages.plant, (t_ns, twin, row, measurement))


class LoopTimes(NamedTuple):
    """What `closed_loop` measured."""

    seconds: float
    """Simulated [s]."""
    seconds_per_second: float
    """Simulated time over wall time, on one core: ticks, twin and all."""
    tick_us: float
    """Median duration of a tick [us]."""


def closed_loop(parameters: RigParameters, seconds: float) -> LoopTimes:
    """Simulate `seconds` [s] of a rig on its twin that follows a target round a circle; arming is not counted.

    Raises TendrilError if the rig does not follow to the end.
    """
    rig, twin = build_rig(parameters, BOOT), build_twin(parameters)
    stages = stages_of(rig, twin)
    inputs = Inputs(to_record(Command(boot=BOOT)), to_record(Measurement()), to_record(LoopStatus()))
    telemetry = np.zeros(1, record_dtype(Telemetry))
    for request in (Request.NONE, Request.ARM, Request.FOLLOW):
        inputs.command["request"] = request
        inputs.command["request_n"] += 1
        run_ticks(rig, twin, stages, inputs, telemetry, np.zeros(ARMING, np.int64))
    spans = np.zeros(round(seconds / rig.control.dt), np.int64)
    start = time.perf_counter()
    run_ticks(rig, twin, stages, inputs, telemetry, spans)
    wall = time.perf_counter() - start
    if telemetry["mode"][0] != Mode.FOLLOW or not np.isfinite(telemetry["backbone"]).all():
        raise TendrilError(f"the rig ended in mode {Mode(telemetry['mode'][0]).name} instead of following: no times")
    return LoopTimes(seconds, seconds / wall, float(np.median(spans)) * 1e-3)
