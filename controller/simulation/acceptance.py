"""Whether a rig can be started with parameters: rig and twin are built and run for two simulated seconds.

Whatever a rig is to be started with goes through here first: what is accepted must never leave it dead.
"""

import time
from functools import cache
from pathlib import Path

import numpy as np

from controller.arrays import Rows
from controller.assembly.plant import build_plant
from controller.assembly.rig import build_rig
from controller.assembly.statics import scratch_for
from controller.drivers.registry import capture_device, valve_device
from controller.errors import ParameterError
from controller.kernels.model.statics import static_tip
from controller.schema.messages import Command
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import PlantKind, RigParameters, Settings, TwinParameters
from controller.schema.rig_file import RigFile
from controller.simulation.simulate import Simulation

BOOT = 1
STAGES = {Request.NONE: 0.1, Request.ARM: 0.9, Request.FOLLOW: 1.0}
"""What is asked for, and for how long it is simulated [s]."""
PIECE = 50
"""Ticks between two looks at the clock."""
COMPUTE_MAX_S = 10.0
"""Most time that building and running may take here [s]: fifty times as long as usual."""
SHARE = 0.3
"""Of the largest torques, a corner of the admissible ones, at whose static tip the target is."""
DEADLY = (Cause.NOT_FINITE, Cause.TOO_FAST, Cause.PRESSURE, Cause.PRESSURE_MISMATCH)
"""What no gains mend: the numbers run away, or the pressures are beyond the chambers."""
DYNAMICS = "k, b, alpha, mass, length and pressure_map"


def require_built(parameters: RigParameters) -> None:
    """Raise ParameterError unless all that a rig process builds at its start can be built."""
    _build(parameters)


def accepted_rig(found: RigFile, folder: Path, in_force: Settings | None = None) -> RigParameters:
    """What a rig process is started with by the rig file `found` in `folder`.

    ParameterError unless its drivers are there and take their options, and it stood and moved here (`require_running`).
    """
    capture_device(found.motion_capture)
    valve_device(found.valves)
    parameters = found.parameters(folder)
    require_running(parameters, in_force)
    return parameters


def require_running(parameters: RigParameters, in_force: Settings | None = None) -> None:
    """Raise ParameterError unless rig and twin can be built, stand vented and in HOLD, and move with finite numbers.

    With the gains as they are at the start or else with those `in_force`. A move may be ended by a watchdog.
    """
    _compiled(parameters.twin.plant)
    end = time.monotonic() + COMPUTE_MAX_S
    try:
        _run(parameters, Settings(), end)
    except Restless:
        if in_force is None:
            raise
        _run(parameters, in_force, end)


@cache
def _compiled(plant: PlantKind) -> None:
    """Have all kernels of a run here: where they are compiled first, that time is not the actuator's."""
    _build(RigParameters(twin=TwinParameters(plant=plant))).run(1)


class Restless(ParameterError):
    """The rig does not stand still, which may be for its gains."""


def _run(parameters: RigParameters, settings: Settings, end: float) -> None:
    simulation = _build(parameters)
    simulation.write(Command(boot=BOOT, settings=settings))
    dt, smap = parameters.controller.dt, simulation.rig.control.smap
    u = SHARE * smap.polygon.corners[0]
    for request, seconds in STAGES.items():
        simulation.command["request_n"] += 1
        simulation.command["request"] = request
        simulation.command["target"] = static_tip(smap.statics, u[0], u[1], scratch_for(smap))
        _advance(simulation, round(seconds / dt), request != Request.FOLLOW, end)


def _build(parameters: RigParameters) -> Simulation:
    return Simulation(build_rig(parameters, BOOT), build_plant(parameters), Command(boot=BOOT))


def _advance(simulation: Simulation, ticks: int, standing: bool, end: float) -> None:
    """Run on; ParameterError for numbers that run away, a rig that does not stand still, and beyond the time `end`."""
    for done in range(0, ticks, PIECE):
        rows = simulation.run(min(PIECE, ticks - done))
        _require_finite(rows)
        _require_mode(rows, standing)
        if time.monotonic() > end:
            raise ParameterError(
                f"{DYNAMICS}: two seconds of this actuator take more than {COMPUTE_MAX_S:.0f} s to compute"
            )


def _require_finite(rows: Rows) -> None:
    for name in ("u", "p_hat", "backbone", "twin_backbone", "pressure_cmd", "pressure_meas"):
        if not np.isfinite(rows[name]).all():
            raise ParameterError(f"{DYNAMICS}: {name} of this actuator is not finite while it is simulated")


def _require_mode(rows: Rows, standing: bool) -> None:
    stopped = rows[np.isin(rows["mode"], (Mode.REST, Mode.FAULT, Mode.E_STOP))]
    if not stopped.size:
        return
    mode, cause = Mode(stopped["mode"][0]), Cause(stopped["cause"][0])
    if cause in DEADLY:
        raise ParameterError(f"{DYNAMICS}: the rig with this actuator goes to {mode.name} ({cause.name})")
    if standing:
        raise Restless(f"{DYNAMICS}: the rig with this actuator does not stand still: {mode.name} ({cause.name})")
