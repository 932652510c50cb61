"""The safety states as data: where each request leads, and what each watchdog watches (docs/safety.md).

The loop acts by these tables (`kernels/safety/safety.py`), docs/safety.md shows them, and the tests walk through them.
"""

from dataclasses import dataclass
from enum import IntEnum

from controller.schema.modes import Cause, Mode, Request

VENTED, HOLD, FOLLOW, TRACK, REST, FAULT, E_STOP = Mode

TRANSITIONS: dict[Mode, dict[Request, Mode]] = {
    VENTED: {Request.ARM: HOLD},
    HOLD: {Request.HOLD: HOLD, Request.FOLLOW: FOLLOW, Request.TRACK: TRACK, Request.REST: REST},
    FOLLOW: {Request.HOLD: HOLD, Request.FOLLOW: FOLLOW, Request.REST: REST},
    TRACK: {Request.HOLD: HOLD, Request.FOLLOW: FOLLOW, Request.REST: REST},
    REST: {Request.HOLD: HOLD, Request.REST: REST},
    FAULT: {Request.CLEAR: VENTED},
    E_STOP: {Request.CLEAR: VENTED},
}
"""Mode after a request; what is missing is refused. Beside these NONE changes nothing, and E_STOP always stops."""

MOVING = (FOLLOW, TRACK)
"""The reference itself may move."""
LIVE = (HOLD, *MOVING)
"""The reference rules u."""
DRIVEN = (*LIVE, REST, FAULT)
"""Chambers may hold pressure."""
LATCHED = (FAULT, E_STOP)
"""Only a CLEAR leads out, and no end of a process."""


KEPT = (Cause.OSCILLATION, Cause.TRACKING_RMS)
"""Where REST ends, VENTED keeps these causes: armed again with the same gains, the same would happen."""


def next_mode(mode: Mode, request: Request) -> Mode | None:
    """Mode after `request` in `mode`; None: refused."""
    return {Request.NONE: mode, **TRANSITIONS[mode], Request.E_STOP: E_STOP}.get(request)


class Watch(IntEnum):
    """The watchdogs, in the order in which they look."""

    LOOP = 0
    OPERATOR = 1
    SERVER_SILENT = 2
    SERVER_GONE = 3
    PUMP_SILENT = 4
    PUMP_GONE = 5
    MARKERS_LOST = 6
    MARKERS_JUMPED = 7
    MARKERS_FROZEN = 8
    ERROR = 9
    ERROR_RMS = 10
    OSCILLATION = 11
    RESIDUAL = 12
    SPEED = 13
    FLOW = 14
    NUMBERS = 15
    PRESSURE = 16
    PRESSURES_LOST = 17


@dataclass(frozen=True)
class Watchdog:
    """One line of the watchdog table."""

    watched: str
    """What passes its bound, in words."""
    limits: tuple[str, ...]
    """The bound, and what else rules it: fields of SafetyLimits."""
    modes: tuple[Mode, ...]
    """Where it acts."""
    reaction: Mode
    cause: Cause


UNSTOPPED = tuple(mode for mode in Mode if mode != E_STOP)
WATCHDOGS: dict[Watch, Watchdog] = {
    Watch.LOOP: Watchdog("gap between two ticks", ("loop_gap",), MOVING, HOLD, Cause.LOOP_STALLED),
    Watch.OPERATOR: Watchdog(
        "operator's presence, age; not in a TRACK run started as unattended",
        ("operator_timeout",),
        MOVING,
        HOLD,
        Cause.OPERATOR_LOST,
    ),
    Watch.SERVER_SILENT: Watchdog("last command, age", ("server_hold",), MOVING, HOLD, Cause.SERVER_LOST),
    Watch.SERVER_GONE: Watchdog("last command, age", ("server_rest",), LIVE, REST, Cause.SERVER_LOST),
    Watch.PUMP_SILENT: Watchdog(
        "heartbeat of the rig's Python side, age", ("pump_hold",), MOVING, HOLD, Cause.PUMP_LOST
    ),
    Watch.PUMP_GONE: Watchdog("heartbeat of the rig's Python side, age", ("pump_rest",), LIVE, REST, Cause.PUMP_LOST),
    Watch.MARKERS_LOST: Watchdog(
        "usable sample of a switched-on marker, age", ("measurement_lost",), LIVE, FAULT, Cause.MEASUREMENT_LOST
    ),
    Watch.MARKERS_JUMPED: Watchdog(
        "the same, while samples come in which they jumped",
        ("measurement_lost", "jump_max", "jump_speed"),
        LIVE,
        FAULT,
        Cause.MEASUREMENT_JUMPED,
    ),
    Watch.MARKERS_FROZEN: Watchdog(
        "change of the torque on the model since any marker last moved at all, if that was long ago",
        ("frozen_torque", "frozen_time"),
        LIVE,
        FAULT,
        Cause.MEASUREMENT_FROZEN,
    ),
    Watch.ERROR: Watchdog(
        "time with a tracking error above its limit, in closed loop; time below counts back",
        ("error_time", "error_max"),
        LIVE,
        FAULT,
        Cause.TRACKING_ERROR,
    ),
    Watch.ERROR_RMS: Watchdog(
        "rms of the tracking error about its mean, both over a window, in closed loop",
        ("error_rms_max", "error_rms_time"),
        LIVE,
        REST,
        Cause.TRACKING_RMS,
    ),
    Watch.OSCILLATION: Watchdog(
        "time for which the tracking error swings faster than 1.6 Hz by more (rms) than its limit and its ratio to the "
        "swing of the reference (root of both squares' sum), in closed loop; time below counts back",
        ("swing_time", "swing_max", "swing_ratio"),
        LIVE,
        REST,
        Cause.OSCILLATION,
    ),
    Watch.RESIDUAL: Watchdog(
        "time with used markers further (rms) from the observer than the limit; time below counts back",
        ("residual_time", "residual_max"),
        LIVE,
        FAULT,
        Cause.RESIDUAL,
    ),
    Watch.SPEED: Watchdog(
        "speed of the observer's last rod, over the root of its `observer_kappa`",
        ("speed_max",),
        DRIVEN,
        E_STOP,
        Cause.TOO_FAST,
    ),
    Watch.FLOW: Watchdog(
        "time with a pair's pressure difference further from that of the model than its limit; time below counts back "
        "half as fast; half of both is enough where a reading stands still while its torque moves",
        ("pressure_off_time", "pressure_off_max"),
        DRIVEN,
        E_STOP,
        Cause.PRESSURE_MISMATCH,
    ),
    Watch.NUMBERS: Watchdog(
        "a number of command, estimate or torque that is not finite", (), UNSTOPPED, E_STOP, Cause.NOT_FINITE
    ),
    Watch.PRESSURE: Watchdog(
        "a measured pressure above its largest, below its least or not a number",
        ("pressure_max", "pressure_min"),
        UNSTOPPED,
        E_STOP,
        Cause.PRESSURE,
    ),
    Watch.PRESSURES_LOST: Watchdog(
        "chamber pressures of hardware, age, or of the last ones at which its board obeyed",
        ("pressures_lost",),
        DRIVEN,
        E_STOP,
        Cause.PRESSURES_LOST,
    ),
}
"""Every age counts on the loop's own clock, without the loop's own stalls."""
