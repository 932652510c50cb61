"""The plant of a virtual rig: a twin or Cosserat rod at 1 kHz in a thread of its own, and no observer or controller."""

import threading
import time
from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Rows, Words
from controller.assembly.plant import Plant, Simulated, build_plant
from controller.assembly.stages import step_of
from controller.kernels.function_pointer import FunctionPointer, call
from controller.realtime.clock import now_ns, sleep_until
from controller.realtime.compiled import compiled, load_acquire
from controller.realtime.mailbox import mailbox, post, receive, words
from controller.realtime.priority import raise_thread_priority
from controller.schema.layout import record_dtype
from controller.schema.messages import Measurement, Telemetry, ValveCommand
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters
from controller.system.thread import SupervisedThread

BEHIND_MAX_NS = 1_000_000_000
"""A plant that is further behind than this goes on from there [ns]: its machine slept."""
E_STOP, HOLD = int(Mode.E_STOP), int(Mode.HOLD)


class PlantMemory(NamedTuple):
    """What the plant's thread shares with those of the wires."""

    step: FunctionPointer
    stop: Words
    """(1,) 1: end."""
    drives: Words
    """Mailbox of ValveCommand, by chamber."""
    shown: Words
    """Mailbox of Measurement: pressures of this tick, markers of the sample delivered last."""
    drive: np.ndarray
    drive_words: Words
    telemetry: np.ndarray
    """Only what a plant reads and writes of it."""
    sensed: np.ndarray
    sensed_words: Words
    scratch: Words


def plant_memory(plant: Simulated) -> PlantMemory:
    """For `plant`, before the first command: vented."""
    drive, telemetry, sensed = (np.zeros(1, record_dtype(model)) for model in (ValveCommand, Telemetry, Measurement))
    drive["vent"] = 1
    return PlantMemory(
        step=step_of(plant),
        stop=np.zeros(1, np.int64),
        drives=mailbox(drive.dtype),
        shown=mailbox(sensed.dtype),
        drive=drive,
        drive_words=words(drive),
        telemetry=telemetry,
        sensed=sensed,
        sensed_words=words(sensed),
        scratch=np.zeros(len(words(drive)), np.int64),
    )


@compiled
def run_plant(plant: Plant, memory: PlantMemory, raw: bool, period_ns: int) -> None:
    """Step `plant` every `period_ns` until told to stop; it makes up for slots that it missed, and has their times.

    A plant that left them out would be slower than the rig beside it believes, by as much as the machine is busy.
    """
    clock = np.zeros(4, np.int64)
    drive, telemetry = memory.drive[0], memory.telemetry[0]
    seen = 0
    deadline = now_ns(clock) + period_ns
    while load_acquire(memory.stop, 0) == 0:
        sleep_until(clock, deadline)
        seen = receive(memory.drives, seen, memory.scratch, memory.drive_words)
        telemetry.mode = E_STOP if drive.cut != 0 else HOLD
        for j in range(4):
            asked = drive.openings[j] if raw else drive.pressures[j]
            telemetry.pressure_cmd[j] = asked if drive.vent == 0 else -1.0 if raw else 0.0
        call(memory.step, (deadline, plant, telemetry, memory.sensed[0]))
        post(memory.shown, memory.sensed_words)
        deadline = next_slot(deadline, now_ns(clock), period_ns)


@compiled
def next_slot(slot: int, now: int, period_ns: int) -> int:
    """The slot after `slot` [ns]: none is left out, however busy the machine, unless it slept."""
    return max(slot, now - BEHIND_MAX_NS) + period_ns


class RunningPlant:
    """The plant and its thread."""

    def __init__(self, parameters: RigParameters, raw: bool) -> None:
        """`raw`: the valves take openings. Compiles, or loads, all that the thread calls."""
        self.plant: Simulated = build_plant(parameters)
        self.plant.chambers.raw[0] = raw
        self._raw, self._period_ns = raw, round(parameters.controller.dt * 1e9)
        self._memory = plant_memory(self.plant)
        self._reading = np.zeros(1, record_dtype(Measurement))
        self._scratch = words(self._reading).copy()
        self._posting, self._looking = threading.Lock(), threading.Lock()
        self._thread = SupervisedThread("plant", self._run)
        compile_plant(build_plant(parameters), raw)

    def start(self) -> None:
        """Let its time go on."""
        self._thread.start()
        while self.newest()["t_ns"] == 0 and not self._thread.trouble:
            time.sleep(1e-3)

    def stop(self) -> None:
        """End the thread."""
        self._memory.stop[0] = 1
        self._thread.stop()

    def newest(self) -> np.void:
        """A copy of the newest Measurement."""
        with self._looking:
            receive(self._memory.shown, 0, self._scratch, words(self._reading))
            found: Rows = self._reading.copy()
        row: np.void = found[0]
        return row

    def drive(self, pressures: Array, openings: Array, vent: bool, cut: bool) -> None:
        """Tell the valves: setpoints [Pa] and openings (4,) of u1+, u1-, u2+, u2-."""
        record = np.zeros(1, record_dtype(ValveCommand))
        record["t_ns"], record["vent"], record["cut"] = time.monotonic_ns(), vent, cut
        record["pressures"], record["openings"] = pressures, openings
        with self._posting:
            post(self._memory.drives, words(record))

    def _run(self) -> None:
        raise_thread_priority()
        run_plant(self.plant, self._memory, self._raw, self._period_ns)


def compile_plant(spare: Simulated, raw: bool) -> None:
    """Compile, or load from the cache, all that the thread calls; `spare` is never stepped."""
    memory = plant_memory(spare)
    memory.stop[0] = 1
    run_plant(spare, memory, raw, 1_000_000)
    post(memory.drives, memory.drive_words)
    receive(memory.shown, 0, np.zeros(len(memory.sensed_words), np.int64), memory.sensed_words)
