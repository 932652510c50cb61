"""The page's reference menu: the library's planned references and the recorded live path, as one actuator has them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.reference import library
from controller.reference.reference import Reference
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters, RigParameters
from controller.simulation.live_path import read_marker_path
from server.drawing.errors import UnknownReference
from server.drawing.messages import ReferenceInfo, ReferencePath
from server.drawing.picture import POINTS, points, times

SPEED_WINDOW = 0.25
"""Time over which the speed of a recorded path is averaged [s]: its samples come unevenly."""


@dataclass(frozen=True)
class Title:
    """A reference in words."""

    task: str
    title: str


TITLES = {
    "step": Title("Steps", "Four steps"),
    **{f"digit_{value}": Title("Task 1: digits and VU", f"Digit {value}") for value in range(10)},
    "vu": Title("Task 1: digits and VU", "VU"),
    "vertical_0.25hz": Title("Task 2: periodic", "Vertical line, 0.25 Hz"),
    "vertical_1hz": Title("Task 2: periodic", "Vertical line, 1 Hz"),
    "horizontal_0.25hz": Title("Task 2: periodic", "Horizontal line, 0.25 Hz"),
    "horizontal_1hz": Title("Task 2: periodic", "Horizontal line, 1 Hz"),
    "circle_0.25hz": Title("Task 2: periodic", "Circle, 0.25 Hz"),
    "circle_1hz": Title("Task 2: periodic", "Circle, 1 Hz"),
    "circle_2hz": Title("Task 3: other actuators", "Circle, 2 Hz"),
    "sensing_sweep": Title("Task 4: sensing", "Sweep (sensing)"),
    "sensing_circle": Title("Task 4: sensing", "Circle, 0.25 Hz (sensing)"),
    "sensing_vertical": Title("Task 4: sensing", "Vertical line, 0.25 Hz (sensing)"),
    "live_path": Title("Task 5: live", "Live path"),
    **{name: Title("Frequency sweep", f"Circle, {f:g} Hz (frequency sweep)") for name, f in library.SWEEP.items()},
}
"""Every reference of the menu, in its order: the name that requests give, and what people call it everywhere."""
_NAMES = {title.title: name for name, title in TITLES.items()}


@dataclass(frozen=True)
class Drawn:
    """A reference as the page draws it."""

    info: ReferenceInfo
    path: ReferencePath


def listed(rig: RigParameters) -> list[ReferenceInfo]:
    """The menu of this rig's actuator."""
    return [drawn.info for drawn in _menu(rig.actuator, rig.controller).values()]


def path(rig: RigParameters, name: str) -> ReferencePath:
    """The points of one reference; raises UnknownReference with the known names."""
    return _menu(rig.actuator, rig.controller)[known(name)].path


def known(name: str) -> str:
    """The name in TITLES of a reference that is asked for by it or by its title. Raises UnknownReference."""
    found = _NAMES.get(name, name)
    if found not in TITLES:
        raise UnknownReference(f"reference = {name!r} is not one of {'; '.join(_NAMES)}")
    return found


@lru_cache(maxsize=4)
def _menu(actuator: Actuator, controller: ControllerParameters) -> dict[str, Drawn]:
    """All references by name: half a second of work, so they are kept, for the actuators that were asked for last."""
    planned = {name: _planned(name, actuator, controller) for name in TITLES if name in library.PLANS}
    return {name: planned[name] if name in planned else _live(name) for name in TITLES}


def _planned(name: str, actuator: Actuator, controller: ControllerParameters) -> Drawn:
    """A reference of the library; without its approach, and with the reason, where it is out of reach."""
    plan, dt = library.PLANS[name], controller.dt
    try:
        found, reason = library.reference(name, actuator, controller), ""
    except ParameterError as error:
        found = Reference(name, library.placed(plan, actuator, dt), round(plan.waits / dt))
        reason = str(error)
    t = np.linspace(0.0, (len(found.p) - 1) * dt, len(found.p))
    apart = np.linalg.norm(np.diff(found.p[found.start :], axis=0), axis=1)
    info = ReferenceInfo(
        name=name,
        task=TITLES[name].task,
        title=TITLES[name].title,
        duration=plan.duration - plan.waits,
        approach=found.start * dt,
        length=float(apart.sum()),
        peak_speed=None if plan.steps else float(apart.max() / dt),
        frequency=plan.frequency,
        K_FF=controller.reference_K_FF if plan.velocity_feedforward else 0.0,
        reachable=not reason,
        reason=reason,
    )
    return Drawn(info, _path(name, t, found.p, [found.start, *found.steps]))


def _live(name: str) -> Drawn:
    """The recorded path. It is followed live, projected into the reach, so it is never out of reach."""
    marker = read_marker_path()
    t, p = marker.t - marker.t[0], marker.p
    even = np.column_stack([np.interp(np.arange(0.0, t[-1], SPEED_WINDOW), t, p[:, j]) for j in range(2)])
    speed = np.linalg.norm(np.diff(even, axis=0), axis=1) / SPEED_WINDOW
    info = ReferenceInfo(
        name=name,
        task=TITLES[name].task,
        title=TITLES[name].title,
        duration=float(t[-1]),
        approach=0.0,
        length=float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()),
        peak_speed=float(speed.max()),
        frequency=None,
        K_FF=0.0,
        reachable=True,
        reason="",
    )
    return Drawn(info, _path(name, t, p, [0]))


def _path(name: str, t: Array, p: Array, keep: list[int]) -> ReferencePath:
    """Evenly chosen points to a hundredth of a millimetre, with both sides of every row of `keep`, and the last."""
    sides = [row for kept in keep for row in (kept - 1, kept) if row >= 0]
    stride = -(-len(p) // (POINTS - len(sides) - 1))
    rows = np.union1d(np.arange(0, len(p), stride), [*sides, len(p) - 1])
    return ReferencePath(name=name, t=times(t[rows]), points=points(p[rows]), start=int(np.searchsorted(rows, keep[0])))
