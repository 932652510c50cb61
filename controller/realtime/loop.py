"""The 1 kHz loop: one compiled function on a fixed grid of deadlines, which never needs the GIL.

A slot that has passed when a tick ends is skipped and counted, never caught up, so the grid stays where it began.
"""

from typing import NamedTuple

import numpy as np

from controller.arrays import Words
from controller.assembly.plant import Plant
from controller.assembly.stages import Stages, compiled_here, stages_of
from controller.kernels.control.tick import Rig
from controller.kernels.function_pointer import call
from controller.kernels.plant.hardware import Hardware
from controller.realtime.clock import now_ns, sleep_until, slots_missed
from controller.realtime.compiled import compiled, load_acquire, store_release
from controller.realtime.mailbox import mailbox, post, receive, words
from controller.realtime.ring import (
    BASELINE_LOST,
    BASELINE_TICKS,
    GRID_NS,
    HEADER_WORDS,
    LOOP_NS,
    PAUSED,
    PUMP_NS,
    ROW_WORDS,
    STEPPED,
    STEPS,
    STOP,
    ring_push,
    ring_read,
)
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry, ValveCommand
from controller.schema.modes import Mode

VENTED, E_STOP = int(Mode.VENTED), int(Mode.E_STOP)


class LoopMemory(NamedTuple):
    """Everything the loop reads and writes: shared words and rows, mailboxes, and its own records with word views."""

    stages: Stages
    header: Words
    rows: Words
    commands: Words
    """Mailbox of Command, written by the link."""
    measurements: Words
    """Mailbox of Measurement, written by the drivers, or by a simulated plant after each of its steps."""
    command: np.ndarray
    command_words: Words
    measurement: np.ndarray
    measurement_words: Words
    sensed: np.ndarray
    """A simulated plant's own Measurement, before it is posted."""
    sensed_words: Words
    outlets: Words
    """Mailbox of ValveCommand, read by the driver of a rig's valves."""
    outlet_words: Words
    """What `Hardware` makes in every tick; (0,) with a simulated plant."""
    telemetry: np.ndarray
    telemetry_words: Words
    status: np.ndarray
    scratch: Words


def loop_memory(header: Words, rows: Words, rig: Rig, plant: Plant) -> LoopMemory:
    """Memory of a loop of `rig` and `plant` that writes into the ring of `header` and `rows`, before any command.

    Compiles, or loads from the cache, what the loop calls apart.
    """
    command, measurement, sensed, telemetry, status = (
        np.zeros(1, record_dtype(model)) for model in (Command, Measurement, Measurement, Telemetry, LoopStatus)
    )
    return LoopMemory(
        stages=stages_of(rig, plant),
        header=header,
        rows=rows,
        commands=mailbox(command.dtype),
        measurements=mailbox(measurement.dtype),
        command=command,
        command_words=words(command),
        measurement=measurement,
        measurement_words=words(measurement),
        sensed=sensed,
        sensed_words=words(sensed),
        outlets=mailbox(record_dtype(ValveCommand)),
        outlet_words=words(plant.command) if isinstance(plant, Hardware) else np.zeros(0, np.int64),
        telemetry=telemetry,
        telemetry_words=words(telemetry),
        status=status,
        scratch=np.zeros(max(len(words(command)), len(words(measurement))), np.int64),
    )


@compiled
def run_loop(rig: Rig, plant: Plant, memory: LoopMemory, period_ns: int) -> None:
    """Tick on the grid until STOP is set, then write one last row that drives nothing.

    While it is paused the time of tick and twin stands still: `paused_ns` is how far it is behind the clock.
    """
    clock = np.zeros(4, np.int64)
    status = memory.status[0]
    command_seen = measurement_seen = slot = paused_ns = 0
    deadline = now_ns(clock) + period_ns
    store_release(memory.header, GRID_NS, deadline)
    while load_acquire(memory.header, STOP) == 0:
        sleep_until(clock, deadline)
        t_ns = now_ns(clock)
        command_n = receive(memory.commands, command_seen, memory.scratch, memory.command_words)
        if command_n != command_seen:
            status.server_ns = t_ns - paused_ns
        command_seen = command_n
        measurement_seen = receive(memory.measurements, measurement_seen, memory.scratch, memory.measurement_words)
        runs = step_due(memory.header)
        if runs:
            status.pump_ns = memory.header[PUMP_NS] - paused_ns
            status.lateness_ns = t_ns - deadline
            memory.telemetry[0].slot = slot
            advance(t_ns, paused_ns, clock, rig, plant, memory)
        end_ns = now_ns(clock)
        store_release(memory.header, LOOP_NS, end_ns)
        missed = slots_missed(end_ns, deadline + period_ns, period_ns)
        if runs:
            status.lost += missed
            slot += 1 + missed
        else:
            paused_ns += (1 + missed) * period_ns
        deadline += (1 + missed) * period_ns
    write_vented_row(slot, now_ns(clock), plant, memory)


@compiled
def step_due(header: Words) -> bool:
    """Whether to tick in this slot: unless paused, and then while steps are left, each of which is counted."""
    if load_acquire(header, PAUSED) == 0:
        store_release(header, STEPPED, header[STEPS])
        return True
    if header[STEPPED] >= load_acquire(header, STEPS):
        return False
    store_release(header, STEPPED, header[STEPPED] + 1)
    return True


@compiled
def advance(t_ns: int, paused_ns: int, clock: Words, rig: Rig, plant: Plant, memory: LoopMemory) -> None:
    """One tick at `t_ns` by the clock, one step of the plant, and the row into the ring. `clock` is scratch (4,)."""
    status, telemetry = memory.status[0], memory.telemetry[0]
    call(memory.stages.tick, (t_ns - paused_ns, memory.command[0], memory.measurement[0], status, rig, telemetry))
    status.step_ns = now_ns(clock) - t_ns
    call(memory.stages.plant, (t_ns - paused_ns, plant, telemetry, memory.sensed[0]))
    if memory.outlet_words.shape[0] == 0:
        post(memory.measurements, memory.sensed_words)
    else:
        post(memory.outlets, memory.outlet_words)
    telemetry.t_ns = t_ns
    ring_push(memory.header, memory.rows, memory.telemetry_words)


@compiled
def write_vented_row(slot: int, t_ns: int, plant: Plant, memory: LoopMemory) -> None:
    """The last row of a boot: the last tick's with mode VENTED, no pressure and no torque; STOP holds the cause.

    An E_STOP and its cause stay, and with them the cut: a valve that is stuck would fill its chamber again. Valves of
    hardware are told so, too.
    """
    telemetry = memory.telemetry[0]
    telemetry.tick += 1
    telemetry.slot = slot
    telemetry.t_ns = t_ns
    if telemetry.mode != E_STOP:
        telemetry.mode = VENTED
        telemetry.cause = memory.header[STOP]
    for i in range(telemetry.pressure_cmd.shape[0]):
        telemetry.pressure_cmd[i] = 0.0
    for i in range(telemetry.u.shape[0]):
        telemetry.u[i] = telemetry.u_ff[i] = telemetry.u_fb[i] = 0.0
    if memory.outlet_words.shape[0] > 0:
        call(memory.stages.plant, (t_ns, plant, telemetry, memory.sensed[0]))
        post(memory.outlets, memory.outlet_words)
    ring_push(memory.header, memory.rows, memory.telemetry_words)


@compiled
def run_baseline(header: Words, period_ns: int) -> None:
    """A bare thread beside the loop: it only sleeps on the same grid, half a period later, and counts by the same rule.

    What it loses, any program of its priority would have lost on this machine in the same time.
    """
    clock = np.zeros(4, np.int64)
    while load_acquire(header, GRID_NS) == 0 and load_acquire(header, STOP) == 0:
        sleep_until(clock, now_ns(clock) + period_ns)
    deadline = load_acquire(header, GRID_NS) + period_ns // 2
    deadline += slots_missed(now_ns(clock), deadline, period_ns) * period_ns
    while load_acquire(header, STOP) == 0:
        sleep_until(clock, deadline)
        missed = slots_missed(now_ns(clock), deadline + period_ns, period_ns)
        store_release(header, BASELINE_TICKS, header[BASELINE_TICKS] + 1)
        store_release(header, BASELINE_LOST, header[BASELINE_LOST] + missed)
        deadline += (1 + missed) * period_ns


def compile_loop(rig: Rig, plant: Plant) -> bool:
    """Compile, or load from the cache, all that the loop and its readers call; whether this process had to compile.

    `rig` and `plant` are spares. The loop ends at once because STOP is set, and writes its one row into a ring that is
    thrown away.
    """
    header, rows = np.zeros(HEADER_WORDS, np.int64), np.zeros((4, ROW_WORDS), np.int64)
    header[STOP] = 1
    memory = loop_memory(header, rows, rig, plant)
    run_loop(rig, plant, memory, 1_000_000)
    run_baseline(header, 1_000_000)
    post(memory.commands, memory.command_words)
    ring_read(header, rows, 0, np.empty((1, ROW_WORDS), np.int64))
    return compiled_here(run_loop)
