"""The last stage before a rig's valves: within limits, and through our own pressure loop where the valves are raw."""

import math

import numpy as np

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.plant.valve import PressureLoop, regulate
from controller.kernels.safety.safety import E_STOP, VENTED


class Hardware(Group):
    """Stands where a simulated plant would, and only passes on what the rig is to do; built by `build_plant`."""

    command: np.ndarray
    """(1,) ValveCommand record: what leaves in this tick; its setpoints are those of the last one until then."""
    dt: float
    """Period of the loop [s]."""
    pressure_max: float
    """No setpoint above it leaves [Pa]."""
    slew_max: float
    """No setpoint rises or falls faster [Pa/s]."""
    raw: bool
    """The valves take openings, not setpoints."""
    loop: PressureLoop
    integral: Array
    """(4,) of the pressure loops, as an opening."""


@kernel
def hardware_step(t_ns: int, hardware: Hardware, telemetry: Record, out_measurement: Record) -> None:
    """Make the command of this tick from telemetry.pressure_cmd: vented unless chambers may be driven, within limits.

    There is no sample in `out_measurement`: the rig's drivers measure. Paper, "Hardware setup": the loops of raw
    valves; the limits are ours. In place: hardware, telemetry.twin_backbone.
    """
    out_measurement.t_ns = 0
    telemetry.twin_backbone[:] = math.nan
    command = hardware.command[0]
    command.t_ns = t_ns
    command.cut = 1 if telemetry.mode == E_STOP else 0
    command.vent = 1 if telemetry.mode == E_STOP or telemetry.mode == VENTED else 0
    for j in range(4):
        if not math.isfinite(telemetry.pressure_cmd[j]):
            command.vent = 1
    for j in range(4):
        if command.vent != 0:
            command.pressures[j], hardware.integral[j], command.openings[j] = 0.0, 0.0, -1.0
            continue
        p_set = limited(telemetry.pressure_cmd[j], command.pressures[j], hardware)
        command.pressures[j], command.openings[j] = p_set, 0.0
        if hardware.raw:
            e = p_set - telemetry.pressure_meas[j]
            command.openings[j], hardware.integral[j] = regulate(hardware.loop, e, hardware.integral[j], hardware.dt)


@kernel
def limited(wanted: float, last: float, hardware: Hardware) -> float:
    """Setpoint [Pa] next after `last` on the way to `wanted`, within range and rate. Not in the paper: safety."""
    most = hardware.slew_max * hardware.dt
    wanted = min(hardware.pressure_max, max(0.0, wanted))
    return min(last + most, max(last - most, wanted))
