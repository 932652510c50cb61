"""A rig on its twin in a world that may break: who is there, what the sensors show and when the loop runs."""

from typing import Any, NamedTuple

import numpy as np

from controller.arrays import Rows
from controller.assembly.rig import build_rig
from controller.assembly.stages import stages_of
from controller.assembly.twin import build_twin
from controller.kernels.function_pointer import call
from controller.kernels.memory import STATE
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry
from controller.schema.modes import Request
from controller.schema.parameters import RigParameters, SafetyLimits, TwinParameters
from tests.controller.chains import compiled

BOOT, MS = 7, 1_000_000
LIMITS = SafetyLimits(server_rest=1.0, pump_rest=1.0, error_time=0.5)
"""Waits of the real ones that would only take the test's time."""


class Switches(NamedTuple):
    """What is there in the next ticks, each (1,) int64; `pressures` (4,) [Pa] replace the sensors' where not -1."""

    operator: np.ndarray
    server: np.ndarray
    pump: np.ndarray
    pressures: np.ndarray


@compiled
def advance(
    rig: Any, twin: Any, stages: Any, switches: Switches, now: np.ndarray, records: Any, rows: Rows, states: Rows
) -> None:
    """One tick for each of `rows`; `states` get the memory after it, `now` (1,) [ns] is the last tick's."""
    command, measurement, status = records[0][0], records[1][0], records[2][0]
    for n in range(rows.size):
        now[0] += 1_000_000
        command.presence += switches.operator[0]
        if switches.server[0] != 0:
            status.server_ns = now[0]
        if switches.pump[0] != 0:
            status.pump_ns = now[0]
        call(stages.tick, (now[0], command, measurement, status, rig, rows[n]))
        states[n] = rig.control.state[0]
        call(stages.plant, (now[0], twin, rows[n], measurement))
        for j in range(4):
            if switches.pressures[j] != -1.0:
                measurement.pressures[j] = switches.pressures[j]


class World:
    """One boot of a rig; every `run` returns telemetry and memory, the last row before it first."""

    def __init__(self) -> None:
        parameters = RigParameters(limits=LIMITS, twin=TwinParameters(rods=6))
        self.rig, self.twin = build_rig(parameters, BOOT), build_twin(parameters)
        self._stages = stages_of(self.rig, self.twin)
        self.switches = Switches(*(np.ones(1, np.int64) for _ in range(3)), np.full(4, -1.0))
        self.now = np.array([1000 * MS])
        self.records = (to_record(Command(boot=BOOT)), to_record(Measurement()), to_record(LoopStatus()))
        self.command = self.records[0]
        self.rows, self.states = np.zeros(1, record_dtype(Telemetry)), np.zeros(1, STATE)
        self._advance(1)

    def run(self, ticks: int) -> tuple[Rows, Rows]:
        before = self.rows[-1:], self.states[-1:]
        self._advance(ticks)
        return np.concatenate([before[0], self.rows]), np.concatenate([before[1], self.states])

    def stall(self, milliseconds: int) -> None:
        self.now += milliseconds * MS

    def ask(self, request: int) -> None:
        self.command["request_n"] += 1
        self.command["request"] = request

    def go(self, *requests: Request) -> None:
        """Ask for one after the other, 30 ms apart."""
        for request in requests:
            self.ask(request)
            self._advance(30)

    def _advance(self, ticks: int) -> None:
        self.rows, self.states = np.zeros(ticks, record_dtype(Telemetry)), np.zeros(ticks, STATE)
        advance(self.rig, self.twin, self._stages, self.switches, self.now, self.records, self.rows, self.states)
