"""The words that kernels and messages share, as plain enumerations: integrator, law, mode, request, cause."""

from enum import IntEnum


class Integrator(IntEnum):
    """How the observer steps its model through one period; both state order, stability and energy in their kernels."""

    RK4 = 0
    """`kernels.integrate.rk4_step`: order 4, stable up to a bound that falls with the number of rods."""
    IMPLICIT = 1
    """`kernels.implicit.implicit_step`: order 2, stable for any number of rods, stiffness and damping."""


class Law(IntEnum):
    """Which terms make the command u (paper, table "Step response average error characterization")."""

    OPEN_LOOP = 0
    """u is set directly by the operator (`u_open`): neither feedforward nor feedback."""
    FF = 1
    FF_P = 2
    FF_I = 3
    FF_PI = 4


class Mode(IntEnum):
    """Safety state of the rig (docs/safety.md). FAULT and E_STOP latch."""

    VENTED = 0
    HOLD = 1
    FOLLOW = 2
    TRACK = 3
    REST = 4
    """u is brought to zero at a bounded rate, then VENTED."""
    FAULT = 5
    E_STOP = 6


class Request(IntEnum):
    """What an operator can ask for; the rig accepts or refuses it by its transition table."""

    NONE = 0
    ARM = 1
    HOLD = 2
    FOLLOW = 3
    TRACK = 4
    REST = 5
    CLEAR = 6
    E_STOP = 7


STILLING = frozenset({Request.HOLD, Request.REST})
"""What only ends motion: the server may ask for it by itself, and who takes control does."""

E_STOP_STRIDE = 1 << 20
"""By how much the number of an E-STOP is above every one that was used: nothing that is on its way is above it, and who
sees the numbers leap knows that there was one."""


class RowKind(IntEnum):
    """What a row of a planned reference is for."""

    TRAVEL = 0
    """It leads to another pose of the arm."""
    DRAWN = 1
    """It is part of a path that anyone may have drawn."""
    KNOWN = 2
    """It is part of a shape that the arm is known to follow."""
    FED = 3
    """The same, and its figures were published with the velocity feedforward on."""


class Cause(IntEnum):
    """Why the rig is in its mode, or why it refused."""

    NONE = 0
    OPERATOR = 1
    """Asked for by an operator."""
    START = 2
    OPERATOR_LOST = 3
    SERVER_LOST = 4
    PUMP_LOST = 5
    MEASUREMENT_LOST = 6
    LOOP_STALLED = 7
    NOT_FINITE = 8
    PRESSURE = 9
    TRACKING_ERROR = 10
    REFERENCE_DONE = 11
    RESTED = 12
    WRONG_MODE = 13
    """Refused: the transition table does not allow the request in this mode."""
    WRONG_BOOT = 14
    """Refused: the command was meant for an earlier boot of the rig."""
    NO_REFERENCE = 15
    NO_OPERATOR = 16
    """Refused: a moving mode needs an operator who is present."""
    MEASUREMENT_FROZEN = 17
    """Samples come, but nothing moves in them though the torque changed."""
    MEASUREMENT_JUMPED = 18
    """Samples come, but further off than the arm can have moved."""
    PRESSURE_MISMATCH = 19
    """The chambers do not follow their setpoints: sensor, valve or supply."""
    TOO_FAST = 20
    OSCILLATION = 21
    """The feedback makes the tip swing fast, by more than the reference explains."""
    TRACKING_RMS = 22
    """The tracking error swings widely."""
    RESIDUAL = 23
    """The observer is far from the markers that it uses."""
    PRESSURES_LOST = 24
    """The valves' board does not say the pressures any more, or says that it drives nothing."""


class Freeze(IntEnum):
    """How the twin's motion capture is frozen."""

    OFF = 0
    OLD_TIME = 1
    """The last sample is delivered again as it was, so nothing new is."""
    FRESH_TIME = 2
    """The last positions are delivered under new times of capture."""


REASONS = {
    Cause.WRONG_BOOT: "the rig has restarted since; read its state and arm again",
    Cause.NO_REFERENCE: "no reference is planned",
    Cause.NO_OPERATOR: "no operator is present",
}
"""What a refusal means."""
NEXT_STEPS = {
    Mode.VENTED: "arm first",
    Mode.REST: "wait until the rig is vented",
    Mode.FAULT: "clear the fault first",
    Mode.E_STOP: "clear the E-STOP first",
}
"""What an operator does first."""


def refused_text(request: Request, mode: Mode, cause: Cause) -> str:
    """Why `request` was refused in `mode`, as "refused: FOLLOW is not possible in VENTED; arm first"."""
    if cause in REASONS:
        return f"refused: {REASONS[cause]}"
    hint = NEXT_STEPS.get(mode)
    return f"refused: {request.name} is not possible in {mode.name}" + (f"; {hint}" if hint else "")
