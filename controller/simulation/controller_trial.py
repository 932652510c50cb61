"""A controller of a package, on the twin for some seconds before a rig has it: what it says, and for how long."""

import math
import time

import numpy as np

from controller.arrays import Array, Rows
from controller.assembly.controllers.registry import OURS, controllers, index_of, with_controller
from controller.assembly.controllers.slot import compiled
from controller.errors import ProcessKilled
from controller.reference.feasible.reach import static_tips
from controller.reference.reference import Reference
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.run import armed, plan, request, torques_for
from controller.simulation.simulate import Simulation
from controller.system.work_process import WorkProcess

HOLD_S, FOLLOW_S, TRACK_S = 2.0, 4.0, 4.0
"""Ten seconds: standing, led by hand, along a planned reference."""
SHARE = 0.4
"""Of full torque, that of the pose to which it is led, and half of it to either side of that it tracks."""
CALL_MAX_S = 1e-4
"""Longest call, but for one in a hundred: a tenth of a tick."""
TORQUE_MAX = 2.0
"""Most that it may ask for, as a share of the actuator's own."""
PATIENCE_S = 60.0
"""For all of it: a call that never ends is ended then."""


def unfit(parameters: RigParameters, name: str) -> str:
    """Why the controller of this name may not be in the slot of this rig, in a process of its own; "" where it may."""
    work = WorkProcess("trial of a controller", PATIENCE_S, tries=1)
    try:
        return work.call(tried, parameters, name)
    except ProcessKilled:
        return f"it did not come to the end of a trial of {HOLD_S + FOLLOW_S + TRACK_S:g} s"
    except Exception as error:  # of any kind: it is a package's own
        return f"it is not one: {error}"
    finally:
        work.stop()


def tried(parameters: RigParameters, name: str) -> str:
    """The same in this process."""
    nominal = RigParameters(actuator=parameters.actuator, controller=parameters.controller)
    compiled(controllers()[index_of(name)])
    settings = with_controller(Settings(), name)
    rows, seconds = course(nominal, settings)
    bare = course(nominal, with_controller(settings, OURS[0].name))[1]
    return wrong(rows, nominal) or slow(seconds, bare)


def course(parameters: RigParameters, settings: Settings) -> tuple[Rows, Array]:
    """Telemetry (n,) of the trial, and how long each of its ticks took, plant and all (n,) [s]."""
    simulation = armed(parameters, settings, 0)
    control, dt, u_max = simulation.rig.control, parameters.controller.dt, parameters.actuator.u_max
    pieces = [timed(simulation, round(HOLD_S / dt))]
    simulation.command["target"] = static_tips(control.smap, np.full((1, 2), SHARE * u_max))
    request(simulation, Request.FOLLOW)
    pieces.append(timed(simulation, round(FOLLOW_S / dt)))
    request(simulation, Request.HOLD)
    pieces.append(timed(simulation, 1))
    swing = np.sin(2.0 * math.pi * np.linspace(0.0, 2.0, round(TRACK_S / dt)))[:, None]
    u = SHARE * u_max * (1.0 + 0.5 * swing) * np.ones(2)
    reference = Reference("trial", static_tips(control.smap, u), 0, u=u)
    plan(control, reference, dt, torques_for(parameters, reference, settings))
    request(simulation, Request.TRACK)
    pieces.append(timed(simulation, len(u)))
    return np.concatenate([rows for rows, _ in pieces]), np.concatenate([seconds for _, seconds in pieces])


def timed(simulation: Simulation, ticks: int) -> tuple[Rows, Array]:
    """Rows (ticks,), and what each took of the processor [s]: a machine that stands still is not its fault."""
    rows, clock = np.zeros(ticks, record_dtype(Telemetry)), np.zeros(ticks + 1)
    clock[0] = time.thread_time()
    for n in range(ticks):
        simulation.fill(rows[n : n + 1])
        clock[n + 1] = time.thread_time()
    return rows, np.diff(clock)


def wrong(rows: Rows, parameters: RigParameters) -> str:
    """What is wrong with what it said, "" for nothing."""
    dt, most = parameters.controller.dt, TORQUE_MAX * parameters.actuator.u_max
    ended = np.flatnonzero(~np.isin(rows["mode"], (Mode.HOLD, Mode.FOLLOW, Mode.TRACK)))
    asked = np.abs(rows["u_ff"] + rows["u_fb"]).max(axis=1)
    over = np.flatnonzero(asked > most)
    if over.size and not (ended.size and ended[0] < over[0]):
        return f"it asks for {asked.max():.3g} N m, first after {over[0] * dt:.3g} s, and {most:.3g} is the most"
    if ended.size:
        row = rows[ended[0]]
        cause = "it says what is no number" if row["cause"] == Cause.NOT_FINITE else Cause(int(row["cause"])).name
        return f"{Mode(int(row['mode'])).name} after {ended[0] * dt:.3g} s on the twin: {cause}"
    return ""


def slow(seconds: Array, bare: Array) -> str:
    """By how much its ticks (n,) [s] are longer than the first controller's, "" where they are not too long."""
    call = float(np.percentile(seconds, 99) - np.median(bare))
    if call <= CALL_MAX_S:
        return ""
    return f"a call takes {1e3 * call:.3g} ms (99 % of them less), more than {1e3 * CALL_MAX_S:g}"


def strangers() -> list[str]:
    """Names of those that are not ours."""
    return [one.name for one in controllers()[len(OURS) :]]
