"""A controller of one's own for Tendril's slot: quasi-static feedforward, and an integral in the task space.

In the pyproject.toml of its package:

    [project.entry-points."tendril.controllers"]
    integral = "own_controller:INTEGRAL"
"""

from typing import Annotated

from pydantic import Field

from controller.arrays import Array, Record
from controller.assembly.controllers.definition import Controller, Signal
from controller.kernels.compiled import kernel
from controller.kernels.control.task_space import attainable, through_sensitivity
from controller.schema.layout import Model, Quantity


class IntegralTuning(Model):
    """What it is tuned by: each number with unit, bounds and what is usual."""

    K_I: Annotated[float, Field(ge=0.0, le=10.0), Quantity("1/s", "K_I")] = 1.5


@kernel
def integral(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """u_fb rises by S^+ K_I e a second while the loop is closed, and nothing is cut. In place: memory."""
    if not now.live:
        memory[0] = memory[1] = 0.0
    elif now.begins:
        memory[0], memory[1] = now.u[0] - now.u_ff[0], now.u[1] - now.u_ff[1]
    elif now.closed and not now.saturated:
        e_x, e_y = attainable(now, now.error[0], now.error[1])
        u_1, u_2 = through_sensitivity(now, now.epsilon, tuning[0] * e_x, tuning[0] * e_y)
        memory[0], memory[1] = memory[0] + u_1 * now.dt, memory[1] + u_2 * now.dt
    for j in range(2):
        out_wanted.u_fb[j] = out_wanted.signals[j] = memory[j]


INTEGRAL = Controller(
    name="integral",
    title="Quasi-static feedforward and an integral",
    law=integral,
    citation="an example",
    tuning=IntegralTuning,
    signals=(Signal("u_int_1", "N m"), Signal("u_int_2", "N m")),
    own_gains=True,
)
