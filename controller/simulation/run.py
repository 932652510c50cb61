"""One run of a planned reference on the twin: arm, TRACK to the end, without a clock."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from controller.arrays import Array, Rows
from controller.assembly.controllers.registry import controllers
from controller.assembly.plant import build_plant
from controller.assembly.rig import build_rig
from controller.errors import DataError, TendrilError
from controller.kernels.memory import Control
from controller.reference.reference import Reference
from controller.reference.torques import planned_torques
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import DT, RigParameters, Settings
from controller.simulation.simulate import Simulation
from controller.system.progress import ProgressCallback, no_progress

BOOT = 1
SETTLE, ARMED = 0.05, 0.05
"""Time until the markers have come in; time in HOLD before the run [s]."""
PIECE = 1000
"""Ticks between two signs of progress; without a progress callback a run is one piece, which is quicker by a fifth."""


def run(
    parameters: RigParameters, reference: Reference, settings: Settings, seed: int, told: ProgressCallback = no_progress
) -> Rows:
    """Telemetry (n,) of the reference's n ticks, approach included, under the law and sensors of `settings`.

    As `attempt`; raises TendrilError as well if the rig does not follow to the end.
    """
    rows = attempt(parameters, reference, settings, seed, told)
    require_mode(rows, reference.name, Mode.TRACK, parameters.controller.dt)
    return rows


def attempt(
    parameters: RigParameters, reference: Reference, settings: Settings, seed: int, told: ProgressCallback = no_progress
) -> Rows:
    """Telemetry (n,) of as many ticks as the reference has, whether or not the rig follows it to the end.

    K_FF counts only where the reference has it on, and there from the shape's first point on, not in the approach
    (docs/conventions.md); so one set of gains serves all experiments. `seed` is the twin's: the same seed gives the
    same bits. Raises DataError for a reference that the rig cannot be given.
    """
    simulation = armed(parameters, settings.model_copy(update={"K_FF": (0.0, 0.0)}), seed)
    unfed = replace(reference, velocity_feedforward=False)  # what comes of it is said below
    plan(simulation.rig.control, unfed, planned=torques_for(parameters, reference, settings))
    request(simulation, Request.TRACK)
    total = len(reference.p)
    rows = np.zeros(total, record_dtype(Telemetry))
    every = total if told is no_progress else PIECE
    arrived = min(max(reference.start - 1, 0), total)  # the approach is at rest there: the command does not jump
    for begin, end in pairwise(sorted({*range(0, total, every), arrived, total})):
        if begin == arrived:
            simulation.command["settings"]["K_FF"] = for_reference(settings, reference).K_FF
        simulation.fill(rows[begin:end])
        if end % every == 0 or end == total:
            told(end / total)
    return rows


def armed(parameters: RigParameters, settings: Settings, seed: int) -> Simulation:
    """A rig and its twin in HOLD at rest, ready for a run, with the twin's noise from `seed`."""
    rig, twin = build_rig(parameters, BOOT), build_plant(seeded(parameters, seed))
    simulation = Simulation(rig, twin, Command(boot=BOOT, settings=settings))
    simulation.run(round(SETTLE / rig.control.dt))
    request(simulation, Request.ARM)
    simulation.run(round(ARMED / rig.control.dt))
    return simulation


def for_reference(settings: Settings, reference: Reference) -> Settings:
    """`settings` with K_FF off where the reference has no velocity feedforward."""
    return settings if reference.velocity_feedforward else settings.model_copy(update={"K_FF": (0.0, 0.0)})


def seeded(parameters: RigParameters, seed: int) -> RigParameters:
    """`parameters` with another seed of the twin's noise."""
    return parameters.model_copy(update={"twin": parameters.twin.model_copy(update={"seed": seed})})


def plan(control: Control, reference: Reference, dt: float = DT, planned: Array | None = None) -> None:
    """Put the reference, whose rows are dt [s] apart, in place for TRACK, and the torques `planned` (n,2) [N m] for it.

    Raises DataError if it does not fit the rig's memory or period.
    """
    rows, room = len(reference.p), len(control.reference)
    if not 0 < rows <= room:
        raise DataError(f"{reference.name}: {rows} rows of reference, outside [1, {room}]")
    if abs(control.dt - dt) > 1e-9:
        raise DataError(f"{reference.name}: sampled every {dt} s, but the tick is {control.dt} s")
    if not np.isfinite(reference.p).all():
        raise DataError(f"{reference.name}: a point is not finite")
    control.reference[:rows] = reference.p
    control.guide[:rows] = np.nan if reference.u is None else reference.u
    control.kinds[:rows] = reference.kinds
    control.slot.planned[:rows] = np.nan if planned is None else planned
    control.plan[0] = rows, 0, rows


def torques_for(parameters: RigParameters, reference: Reference, settings: Settings) -> Array | None:
    """Torques (n,2) [N m] that move the model along the reference, if the controller of `settings` follows such."""
    if not controllers()[settings.controller].plans:
        return None
    asked = reference.p if reference.asked is None else reference.asked
    return planned_torques(parameters.actuator, parameters.controller, asked, reference.u)


def request(simulation: Simulation, wanted: Request) -> None:
    """Ask for `wanted` from the next tick on."""
    simulation.command["request_n"] += 1
    simulation.command["request"] = wanted


def require_mode(rows: Rows, name: str, wanted: Mode, dt: float) -> None:
    """Raise TendrilError unless every row is in the mode `wanted`: a run that was broken off has no metrics.

    Rows are dt [s] apart.
    """
    broken = np.flatnonzero(rows["mode"] != wanted)
    if broken.size:
        row = rows[broken[0]]
        mode, cause = Mode(row["mode"]).name, Cause(row["cause"] or row["request_cause"]).name
        raise TendrilError(f"{name}: {mode} ({cause}) after {broken[0] * dt:.3f} s, instead of to the end")
