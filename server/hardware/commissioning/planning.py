"""What this room asks the planner for. The planner alone imports what plans: here that comes when it is called."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from controller.arrays import Array, Rows, Words
from controller.errors import ParameterError
from controller.schema.hardware import PressureLoop, Valves
from controller.schema.parameters import SENSORS, RigParameters
from server.hardware.first_mode.messages import MeasuredMode
from server.hardware.first_mode.planning import as_message
from server.rig.numbered import in_slots

if TYPE_CHECKING:
    from controller.simulation.pneumatic_fit import ChamberSteps

CIRCLE_RADIUS = 0.06
"""Of the first circle, as a share of the actuator's length: 15 mm of P1."""
CIRCLE_SHARES = (0.2, 0.3, 0.4, 0.5, 0.6)
"""Of u_max, for the pose at the circle's middle: the first with which the tip moves well in both directions."""
CIRCLE_POINTS = 64
DIRECTIONS = 16
WELL = 0.4
"""Of the best share of all poses that are looked at, how well the tip must move in its worst direction."""
NUDGE = 0.01
"""Of u_max, by which sensitivities are told."""
RELEASES_LEAST = 4
"""Two to either side, from which an interval can follow."""
SWING_PERIOD = 4e-3
"""Of the rows from which the first mode is found [s]: it takes fifty of them for each swing at 5 Hz."""
INSIDE = 0.9
"""Share of the admissible torques that the circle may need."""


class PressureSteps(NamedTuple):
    """Telemetry of the steps of one chamber."""

    slots: Words
    """(n,) of the loop's grid."""
    asked: Array
    """(n,) setpoint [Pa]."""
    shown: Array
    """(n,) measured [Pa]."""
    starts: tuple[int, ...]
    """Slots at which the steps begin."""


class RawLoop(NamedTuple):
    """What the steps of raw valves tell of them, and of the loop around them."""

    delay: float
    """Of the latest valve, with its spool [s]."""
    fill: tuple[float, ...]
    """Of each chamber, its valve wholly open [Pa/s]."""
    exhaust: tuple[float, ...]
    """The same at 60 kPa [Pa/s]."""
    wanted: PressureLoop
    """The loop that these valves should have."""
    phase: tuple[float, float]
    """Smallest phase margin [deg] of the loop in force, and of the one that is wanted."""
    margin: tuple[float, float]
    """By how much more delay each would swing for good [s]."""


class PressureFit(NamedTuple):
    """What they tell: (value, low, high) [s]."""

    dead_time: tuple[float, float, float]
    lag: tuple[float, float, float]
    inflate: tuple[float, float, float]
    exhaust: tuple[float, float, float]
    residual: float
    """rms [Pa]."""
    gains: tuple[float, ...]
    zeros: tuple[float, ...]
    """What each chamber's sensor shows before it is filled [Pa]."""
    curves: tuple[Array, ...]
    """For each chamber (m,4): time [s], asked, shown and model [Pa]."""


class Release(NamedTuple):
    """Telemetry of one release, from the lead to it until the arm rests."""

    slots: Words
    """(n,) of the loop's grid."""
    pressures: Array
    """(n,4) measured [Pa]."""
    sent: Array
    """(n,2) what the observer takes for them [N m]."""
    tip: Array
    """(n,2) measured [m]; nan where it was not seen."""
    slot: int
    """At which it was released."""


class Believed(NamedTuple):
    """The arm at rest, and how far its chambers move it from there."""

    rods: Array
    """Distal ends of the rods (10,2), the last one the tip [m]."""
    ways: tuple[float, float]
    """Way of the tip by pressure in a chamber of u1, and of u2 [m/Pa]."""


class Circle(NamedTuple):
    """Where the first closed loop goes."""

    middle: tuple[float, float]
    radius: float
    """[m]."""


def believed(rig: RigParameters) -> Believed:
    """Of the rig's actuator, by its static model."""
    from controller.assembly.rod import build_rod
    from controller.assembly.stability import sensor_places
    from controller.assembly.statics import static_map
    from controller.kernels.model.statics import at_rest, points_on
    from controller.reference.feasible.reach import static_tips

    actuator = rig.actuator
    model, rods = build_rod(actuator, actuator.table_rods), np.zeros((SENSORS, 2))
    points_on(at_rest(model).q, sensor_places(model), rods)
    nudge = NUDGE * actuator.u_max
    tips = static_tips(static_map(actuator, rig.controller), nudge * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))
    ways = np.linalg.norm(tips[1:] - tips[0], axis=1) / (nudge * actuator.chamber_slopes.reshape(2, 2).min(axis=1))
    return Believed(rods, (float(ways[0]), float(ways[1])))


def sweep_torques(rig: RigParameters, grid: int, share: float) -> list[tuple[float, float]]:
    """Torques [N m] on a grid of `grid` a side within `share` of the admissible ones, each near the one before."""
    from controller.assembly.statics import static_map
    from controller.kernels.model.polygon import admissible

    polygon, u_max = static_map(rig.actuator, rig.controller).polygon, rig.actuator.u_max
    side = np.linspace(-share, share, grid) * u_max
    found = []
    for row, u1 in enumerate(side):
        for u2 in side if row % 2 == 0 else side[::-1]:
            if admissible(polygon, u1 / share, u2 / share):
                found.append((float(u1), float(u2)))
    return found


def release_torques(rig: RigParameters, share: float, repeats: int) -> list[tuple[float, float]]:
    """Torques [N m] from which the actuator is released: to either side in turn, within `share` of the admissible."""
    from controller.assembly.statics import static_map
    from controller.kernels.model.polygon import nearest_admissible

    polygon, u_max = static_map(rig.actuator, rig.controller).polygon, rig.actuator.u_max
    found = []
    for side in (1.0, -1.0) * repeats:
        u1, u2 = nearest_admissible(polygon, side * u_max, side * u_max)
        found.append((share * float(u1), share * float(u2)))
    return found


def raw_loop(chambers: tuple[PressureSteps, ...], valves: Valves, rig: RigParameters) -> RawLoop:
    """The raw `valves` of the four chambers, and the loop that they should have; ParameterError names the chamber."""
    from controller.simulation.valve_fit import fit_valve, tuned_loop, worst_margins

    found = []
    for number, one in enumerate(chambers, 1):
        try:
            found.append(fit_valve(_on_the_grid(one), valves, rig.controller.dt))
        except ParameterError as error:
            raise ParameterError(f"chamber {number}: {error}") from error
    full = min(valves.pressure_max, rig.actuator.pressure_max)
    wanted = tuned_loop(found, full)
    margins = [worst_margins(loop, found, full) for loop in (valves.loop, wanted)]
    return RawLoop(
        delay=max(one.theta for one in found),
        fill=tuple(one.fill for one in found),
        exhaust=tuple(one.exhaust for one in found),
        wanted=wanted,
        phase=(math.degrees(margins[0].phase), math.degrees(margins[1].phase)),
        margin=(margins[0].delay, margins[1].delay),
    )


def swing(releases: tuple[Release, ...], rig: RigParameters) -> MeasuredMode:
    """Of the first mode; ParameterError with the reason where the releases do not tell it.

    Driven by the measured pressures, as docs/observer.md has it: slow valves count as little as dry friction.
    """
    from controller.simulation.first_mode import StepRecord, driving_torque, first_mode, mode_model

    if len(releases) < RELEASES_LEAST:
        raise ParameterError(f"{len(releases)} releases: at least {RELEASES_LEAST} are needed")
    slots = np.concatenate([one.slots for one in releases])
    every = max(1, round(SWING_PERIOD / rig.controller.dt))
    grid = np.arange(slots[0], slots[-1] + 1, every)
    rows = in_slots(slots, grid)
    pressures, sent, tip = (
        np.concatenate([getattr(one, name) for one in releases])[rows] for name in ("pressures", "sent", "tip")
    )
    released = np.zeros(len(grid), bool)
    for one in releases:
        released |= (grid >= one.slot) & (grid <= one.slots[-1])
    tip[~released] = np.nan  # how it was led there tells nothing
    torque, measured = driving_torque(pressures, sent, rig)
    starts = tuple(int(np.searchsorted(grid, one.slot)) for one in releases)
    found = first_mode(StepRecord(every * rig.controller.dt, torque, tip, starts), mode_model(rig))
    parts = [tip[start:end] for start, end in pairwise((*starts, len(tip)))]
    travel = max(float(np.linalg.norm(np.nanmax(part, axis=0) - np.nanmin(part, axis=0))) for part in parts)
    return as_message(found, measured, travel, len(releases))


def kappa_of(frequency: float, rig: RigParameters) -> float:
    """kappa of a first mode of `frequency` [Hz], which statics leave open; see `ModeModel.kappa`."""
    from controller.simulation.first_mode import mode_model

    return mode_model(rig).kappa(frequency)


def pressure_fit(chambers: tuple[PressureSteps, ...], rig: RigParameters) -> PressureFit:
    """Dead time and lags of the four chambers; ParameterError where the steps do not tell them."""
    from controller.simulation.pneumatic_fit import fit_pneumatics

    dt = rig.controller.dt
    steps = [_on_the_grid(one) for one in chambers]
    fit = fit_pneumatics(steps, dt)
    curves = []
    for step, model in zip(steps, fit.model, strict=True):
        every = max(1, len(model) // 300)
        t = np.arange(len(model)) * dt
        curves.append(np.column_stack((t, step.asked, step.shown, model))[::every])
    return PressureFit(
        dead_time=(fit.dead_time.value, fit.dead_time.low, fit.dead_time.high),
        lag=(fit.lag.value, fit.lag.low, fit.lag.high),
        inflate=(fit.inflate.value, fit.inflate.low, fit.inflate.high),
        exhaust=(fit.exhaust.value, fit.exhaust.low, fit.exhaust.high),
        residual=fit.residual,
        gains=fit.gains,
        zeros=tuple(float(np.nanmedian(one.shown[: one.starts[0]])) for one in steps),
        curves=tuple(curves),
    )


def _on_the_grid(steps: PressureSteps) -> "ChamberSteps":
    """The same, evenly spaced."""
    from controller.simulation.pneumatic_fit import ChamberSteps

    grid = np.arange(steps.slots[0], steps.slots[-1] + 1)
    newest = in_slots(steps.slots, grid)
    starts = tuple(int(start - grid[0]) for start in steps.starts)
    return ChamberSteps(steps.asked[newest], steps.shown[newest], starts)


def small_circle(rig: RigParameters) -> Circle:
    """A circle near the rest that the tip can follow with torque to spare; ParameterError where there is none."""
    from controller.assembly.statics import static_map
    from controller.kernels.model.polygon import admissible
    from controller.reference.feasible.reach import static_tips
    from controller.reference.feasible.within_reach import carried

    smap, u_max = static_map(rig.actuator, rig.controller), rig.actuator.u_max
    angles = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.column_stack((np.cos(angles), np.sin(angles)))
    poses = [share * u_max * way for share in CIRCLE_SHARES for way in ways]
    poses = [u for u in poses if admissible(smap.polygon, *(u / INSIDE))]

    def worst(u: Array) -> float:
        """By how much the tip moves in its worst direction [m/(N m)]."""
        nudge = NUDGE * u_max
        tips = static_tips(smap, u + nudge * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))
        return float(np.linalg.svd((tips[1:] - tips[0]) / nudge, compute_uv=False)[-1])

    turns = 2.0 * math.pi * np.arange(CIRCLE_POINTS) / CIRCLE_POINTS
    radius = CIRCLE_RADIUS * rig.actuator.length
    scores = [worst(u) for u in poses]
    for u, score in zip(poses, scores, strict=True):
        if score < WELL * max(scores):
            continue
        middle = static_tips(smap, u)
        path = carried(smap, middle + radius * np.column_stack((np.cos(turns), np.sin(turns))), u)
        spare = all(admissible(smap.polygon, *(one / INSIDE)) for one in path.u)
        if spare and not path.changes and not path.distance.any():
            return Circle((float(middle[0]), float(middle[1])), radius)
    raise ParameterError(f"no circle of {radius * 1e3:.0f} mm lies within reach with torque to spare")


def still_markers(rows: Rows, rods: tuple[int, ...]) -> Array:
    """Mean markers of `rods` over `rows`, (len(rods), 2) [m]; nan where one was never seen."""
    markers = rows["markers"][:, np.array(rods) - 1]
    seen = np.isfinite(markers).all(axis=2)
    sums = np.where(seen[..., None], markers, 0.0).sum(axis=0)
    with np.errstate(invalid="ignore"):
        found: Array = sums / seen.sum(axis=0)[:, None]
    return found
