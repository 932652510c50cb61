"""When the tick is: how many periods have passed, and whether the feedforward is due."""

from controller.arrays import Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control

CATCH_UP_MAX = 100
"""Most observer steps in one tick: half of a period at 1 kHz."""


@kernel
def begin_tick(t_ns: int, control: Control) -> int:
    """Periods since the tick before: 1, or the number that a stalled observer has to catch up, bounded.

    Not in the paper: safety. In place: control.state.
    """
    state = control.state[0]
    if state.start_ns == 0:
        state.start_ns = state.last_ns = t_ns
    period_ns = control.dt * 1e9
    return min(max(int((t_ns - state.last_ns) / period_ns + 0.5), 1), CATCH_UP_MAX)


@kernel
def feedforward_ticks(settings: Record, dt: float) -> int:
    """Ticks from one static inverse to the next. Paper, "Task 5: Real-Time User-Defined Tracking": 100 Hz."""
    return max(int(settings.feedforward_period / dt + 0.5), 1)


@kernel
def feedforward_due(control: Control, settings: Record) -> bool:
    """Whether this tick solves the static inverse: every `feedforward_period`, and when a mode begins.

    Paper, "Task 5: Real-Time User-Defined Tracking": at 100 Hz there.
    """
    every = feedforward_ticks(settings, control.dt)
    return control.state[0].tick % every == 0 or control.state[0].entered == 1
