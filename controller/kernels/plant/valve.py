"""Four chambers, each behind a proportional 5/3 spool valve that a low-level pressure loop opens.

The paper ("Hardware setup") names the valve, Festo MPYE-5-M5-010-B, and the loop, PI from pressure error to valve
command. Flow is that of ISO 6358: choked below the critical ratio of pressures, elliptic above. Air stays isothermal.
"""

import math

from controller.arrays import Array, Pair, Words
from controller.kernels.compiled import flushed, inlined, kernel
from controller.kernels.group import Group

ATMOSPHERE = 101.325e3
"""What gauge pressures count from, and what the chambers exhaust to [Pa]."""
REFERENCE_PRESSURE = 100e3
"""Pressure of the reference atmosphere (ISO 8778) in which flows are given [Pa]."""
INTEGRAL_BAND = 5e3
"""The loop integrates only this near its setpoint, so that a step leaves no overshoot behind [Pa]."""
INTEGRAL_MAX = 0.012
"""Bound of the integral: a little more than the largest offset of a spool [share of the stroke]."""
SENSORS_STUCK, SPOOLS_STUCK, SUPPLY_LOST = range(3)
OPEN_LINE = 0.05
"""Opening through which a chamber loses its air at least, while the supply line is open [share of the stroke]."""


class PressureLoop(Group):
    """The loop from pressure error to valve command."""

    inflate_gain: float
    """Opening per pressure error while the chamber is below its setpoint [1/Pa]."""
    exhaust_gain: float
    """The same above the setpoint [1/Pa]."""
    integral_time: float
    """Reset time of the loop [s]."""


class Valve(Group):
    """What the four valves and their loops have in common."""

    supply: float
    """Gauge pressure of the supply [Pa]."""
    conductance: float
    """Sonic conductance C of a fully open port [m^3/(s Pa)], in the reference atmosphere."""
    critical_ratio: float
    """Ratio b of downstream to upstream absolute pressure below which the flow is choked."""
    volume: float
    """Of a chamber and its line [m^3]."""
    keep: float
    """Share of the spool's distance from its command that is left after a tick."""
    offset: float
    """Opening at rest that no command asked for [share of the stroke]."""
    loop: PressureLoop


class Chambers(Group):
    """Four chambers (u1+, u1-, u2+, u2-), their valves and the setpoints on their way."""

    pressure: Array
    """(4,) gauge [Pa]."""
    sensed: Array
    """(4,) the same as its sensor shows it, to the valve's loop and to the rig [Pa]."""
    spool: Array
    """(4,) position, -1 (exhausts) .. 1 (fills)."""
    integral: Array
    """(4,) the loops' share of the command."""
    line: Array
    """Ring of setpoints on their way (ticks of dead time + 1, 4) [Pa]; of openings, where the valves are driven raw."""
    raw: Words
    """(1,) 1: the valves take openings from outside, and their own loops are off."""
    valve: Valve
    broken: Words
    """(3,) bits of chambers whose sensor is stuck, bits of those whose spool is, 1 where the supply is lost."""
    torque_per_pascal: Array
    """Real torque on a unit of T_theta per differential pressure of each pair (2,) [N m/Pa]."""


@kernel
def fill_chambers(tick: int, setpoints: Array, dt: float, chambers: Chambers) -> None:
    """Advance the four chambers by dt [s]: dead time, pressure loop, spool, flow; setpoints (4,) [Pa], or openings.

    Paper, "Hardware setup": valves and pressure loops. In place: chambers.
    """
    valve = chambers.valve
    slots = chambers.line.shape[0]
    put, take = tick % slots, (tick + 1) % slots
    for j in range(4):
        chambers.line[put, j] = setpoints[j]
        p, e = chambers.pressure[j], chambers.line[take, j] - chambers.sensed[j]
        if chambers.raw[0] != 0:
            command = min(1.0, max(-1.0, chambers.line[take, j]))
        else:
            command, chambers.integral[j] = regulate(valve.loop, e, chambers.integral[j], dt)
        if not chambers.broken[SPOOLS_STUCK] >> j & 1:
            chambers.spool[j] = flushed(command + (chambers.spool[j] - command) * valve.keep)
        opening = min(1.0, max(-1.0, chambers.spool[j] + valve.offset))
        if chambers.broken[SUPPLY_LOST] != 0:
            opening = -max(abs(opening), OPEN_LINE)
        chambers.pressure[j] = pressure_after(valve, p, valve_flow(valve, opening, p), dt)
        if not chambers.broken[SENSORS_STUCK] >> j & 1:
            chambers.sensed[j] = chambers.pressure[j]


@kernel
def dump(dt: float, chambers: Chambers) -> None:
    """Let the air of all chambers out for dt [s], past the valves: what an E-STOP must do whatever is stuck.

    Not in the paper: safety. In place: chambers.pressure.
    """
    for j in range(4):
        p = chambers.pressure[j]
        chambers.pressure[j] = pressure_after(chambers.valve, p, valve_flow(chambers.valve, -1.0, p), dt)


@inlined
def regulate(loop: PressureLoop, e: float, integral: float, dt: float) -> Pair:
    """Valve command (-1..1) for a pressure error e [Pa], and the new integral: PI with two gains of P, one of I.

    Paper, "Hardware setup": the low-level loops. Anti-windup, ours: the integral moves only near the setpoint and never
    beyond what the spool's offset needs.
    """
    command = e * (loop.inflate_gain if e > 0.0 else loop.exhaust_gain)
    if abs(e) < INTEGRAL_BAND:
        integral += loop.inflate_gain * e * dt / loop.integral_time
        integral = min(INTEGRAL_MAX, max(-INTEGRAL_MAX, integral))
    return min(1.0, max(-1.0, command + integral)), integral


@inlined
def flow_share(ratio: float, b: float) -> float:
    """Share of the choked flow that passes at `ratio` of absolute pressures, downstream to upstream.

    Not in the paper: ISO 6358-1.
    """
    if ratio <= b:
        return 1.0
    s = (ratio - b) / (1.0 - b)
    return math.sqrt(max(0.0, 1.0 - s * s))


@kernel
def valve_flow(valve: Valve, opening: float, p: float) -> float:
    """Flow into a chamber at gauge pressure p [Pa], in the reference atmosphere [m^3/s]; negative: out of it.

    Not in the paper: ISO 6358-1.
    """
    up, down = valve.supply, p
    if opening < 0.0:
        up, down = p, 0.0
    up += ATMOSPHERE
    down += ATMOSPHERE
    return opening * valve.conductance * up * flow_share(down / up, valve.critical_ratio)


@inlined
def pressure_after(valve: Valve, p: float, flow: float, dt: float) -> float:
    """Gauge pressure [Pa] after `flow` [m^3/s] for dt [s], isothermal: V dp = REFERENCE_PRESSURE flow dt.

    Flow ends where pressures are equal, which a tick would step over: its slope has no bound there. Not in the paper.
    """
    p += REFERENCE_PRESSURE * flow * dt / valve.volume
    return min(p, valve.supply) if flow > 0.0 else max(p, 0.0)
