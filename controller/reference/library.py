"""Every planned reference of the experiments by name: shape, timing and place.

What the paper leaves open is ours and says so: the place of the shapes, the sweep, where the steps start from, and the
frequencies of the frequency sweep.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.reference import shapes
from controller.reference.feasible.approach import approach, branch
from controller.reference.reference import Reference
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters

CENTRE = (30e-3, 140e-3)
"""Centre of every shape but VU [m] (ours)."""
VU_CORNER = (-50e-3, 125e-3)
"""Lower left corner of VU [m] (paper, Task 1)."""
SHIFT = {"P3": -33e-3}
"""Shift in y by the actuator's name [m] (the paper shifts for P3 but does not say how far); 0 for any other.

Ours puts the centre as many arm lengths from the rest axis as P1's: 140 mm (1 - 193/253)."""
APPROACH, DIGIT, VU, PERIODIC, FAST, STEP = 2.0, 10.0, 25.0, 7.0, 4.0, 3.0
"""Durations [s] of the paper; FAST ends the 2 Hz circle of P3 at 6 s."""
SWEEP_HZ = 0.125
"""One sweep there and back in 8 s (ours)."""
SWEEP = {f"frequency_sweep_{f:g}hz": f for f in (0.1, 0.25, 0.5, 1.0, 1.5, 2.0)}
"""The frequency sweep: name and frequency [Hz] (the paper gives its ends)."""


class Plan(NamedTuple):
    """A shape with its timing."""

    sample: Callable[[Array], Array]
    """Points (n, 2) about the place at times (n,) [s] after the approach."""
    duration: float
    place: tuple[float, float] = CENTRE
    frequency: float | None = None
    velocity_feedforward: bool = False
    waits: float = 0.0
    """How long the tip waits at the end of the approach [s]; `sample` covers it, and the shape begins after it."""
    steps: int = 0


def names() -> tuple[str, ...]:
    """All references of the library."""
    return tuple(PLANS)


def reference(name: str, actuator: Actuator, controller: ControllerParameters | None = None) -> Reference:
    """The reference `name` for `actuator`, followable on one branch of the observer's static map.

    Raises ParameterError if there is none of this name, or if the actuator cannot reach all of it.
    """
    if name not in PLANS:
        raise ParameterError(f"reference = {name!r} is not one of {', '.join(PLANS)}")
    plan, controller = PLANS[name], controller or ControllerParameters()
    ticks = round(APPROACH / controller.dt)
    p = placed(plan, actuator, controller.dt)
    smap = static_map(actuator, controller)
    start = ticks + round(plan.waits / controller.dt)
    return Reference(
        name=name,
        p=np.vstack([approach(smap, branch(smap, p), ticks), p]),
        start=start,
        steps=tuple(start + round(i * STEP / controller.dt) for i in range(plan.steps)),
        frequency=plan.frequency,
        velocity_feedforward=plan.velocity_feedforward,
        led=ticks,
        known=True,
    )


def placed(plan: Plan, actuator: Actuator, dt: float) -> Array:
    """Rows (n, 2) [m] of `plan` after the approach, where `actuator` draws it."""
    rows = round(plan.duration / dt) + (plan.steps == 0)
    place: Array = np.array([plan.place[0], plan.place[1] + SHIFT.get(actuator.name, 0.0)])
    return plan.sample(np.linspace(0.0, (rows - 1) * dt, rows)) + place


def paced(path: Array, duration: float, place: tuple[float, float] = CENTRE) -> Plan:
    """`path` once, at constant speed."""
    return Plan(lambda t: shapes.along(path, t / duration), duration, place)


def periodic(
    shape: Callable[[Array], Array], frequency: float, duration: float = PERIODIC, feedforward: bool = True
) -> Plan:
    """`shape` over and over; its speed sets in at once after the approach."""
    return Plan(lambda t: shape(frequency * t), duration, frequency=frequency, velocity_feedforward=feedforward)


def stepped() -> Plan:
    """The four steps. The tip first waits at the left corner (ours), so that all four are equally long."""
    corners = shapes.diamond()
    order = np.vstack([corners[-1], corners])
    return Plan(lambda t: order[(t / STEP + 1e-9).astype(int)], STEP * len(order), waits=STEP, steps=len(corners))


sensed = partial(periodic, feedforward=False)
"""Task 4, where the paper does not mention K_FF."""

PLANS: dict[str, Plan] = {
    "step": stepped(),
    **{f"digit_{value}": paced(shapes.digit(value), DIGIT) for value in range(10)},
    "vu": paced(shapes.vu(), VU, VU_CORNER),
    "vertical_0.25hz": periodic(shapes.vertical, 0.25),
    "vertical_1hz": periodic(shapes.vertical, 1.0),
    "horizontal_0.25hz": periodic(shapes.horizontal, 0.25),
    "horizontal_1hz": periodic(shapes.horizontal, 1.0),
    "circle_0.25hz": periodic(shapes.circle, 0.25),
    "circle_1hz": periodic(shapes.circle, 1.0),
    "circle_2hz": periodic(shapes.circle, 2.0, FAST),
    "sensing_sweep": sensed(shapes.sweep, SWEEP_HZ, 1.0 / SWEEP_HZ),
    "sensing_circle": sensed(shapes.circle, 0.25),
    "sensing_vertical": sensed(shapes.vertical, 0.25),
    **{name: periodic(shapes.circle, f, math.ceil(PERIODIC * f) / f) for name, f in SWEEP.items()},
}
