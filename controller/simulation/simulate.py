"""The real tick and the real twin without a clock: every experiment, bench and preview runs through here."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from controller.arrays import Rows, Words
from controller.assembly.plant import Plant
from controller.assembly.stages import Stages, stages_of
from controller.kernels.compiled import kernel
from controller.kernels.control.tick import Rig
from controller.kernels.function_pointer import call
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry

START_NS = 1_000_000_000
"""Clock of the first tick; 0 would mean that nothing has been measured yet."""


class Simulation:
    """One boot of a rig and a twin on a perfect loop, advanced piece by piece.

    The operator is present as long as `present` is True, and every number of `command` may be changed between pieces.
    """

    def __init__(self, rig: Rig, twin: Plant, command: Command) -> None:
        self.rig, self.twin, self.present = rig, twin, True
        self._stages = stages_of(rig, twin)
        self.command = to_record(command)
        self.measurement = to_record(Measurement())
        self._status = to_record(LoopStatus())
        self._ticks = 0

    def write(self, command: Command) -> None:
        """Put `command` in force; its presence counter is the simulation's own."""
        presence = self.command["presence"].copy()
        self.command[:] = to_record(command)
        self.command["presence"] = presence

    def run(self, ticks: int) -> Rows:
        """Telemetry (ticks,) of the next `ticks` periods."""
        rows = np.zeros(ticks, record_dtype(Telemetry))
        self.fill(rows)
        return rows

    def fill(self, out_rows: Rows) -> None:
        """Telemetry of the next periods, one for each of `out_rows` (ticks,)."""
        period_ns = round(self.rig.control.dt * 1e9)
        first = np.array([self._ticks, period_ns, self.present], np.int64)
        _run(self.rig, self.twin, self._stages, first, (self.command, self.measurement, self._status), out_rows)
        self._ticks += len(out_rows)


def simulate(rig: Rig, twin: Plant, commands: Sequence[tuple[int, Command]], ticks: int) -> Rows:
    """Telemetry (ticks,) of a run in which each of `commands` comes into force at its tick; the operator is present."""
    simulation = Simulation(rig, twin, Command(boot=int(rig.control.state["boot"][0])))
    times = sorted(commands, key=lambda item: item[0])
    ends = [start for start, _ in times[1:]] + [ticks]
    rows = [simulation.run(times[0][0] if times else ticks)]
    for (start, command), end in zip(times, ends, strict=False):
        simulation.write(command)
        rows.append(simulation.run(min(end, ticks) - start))
    return np.concatenate(rows)


@kernel
def _run(rig: Rig, twin: Plant, stages: Stages, first: Words, records: tuple[Any, Any, Any], rows: Rows) -> None:
    """Tick and plant in turn, like the real loop: the measurement of a step is seen by the next tick."""
    command, measurement, status = records[0][0], records[1][0], records[2][0]
    for n in range(rows.size):
        slot = first[0] + n
        t_ns = START_NS + slot * first[1]
        status.server_ns = status.pump_ns = t_ns
        command.presence += first[2]
        rows[n].slot = slot
        call(stages.tick, (t_ns, command, measurement, status, rig, rows[n]))
        call(stages.plant, (t_ns, twin, rows[n], measurement))
