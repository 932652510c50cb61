"""The last step: a small slow circle under feedback, at half the gains, and how near the tip keeps to it."""

import asyncio
import math

import numpy as np
from pydantic import JsonValue

from controller.arrays import Rows
from controller.errors import CommandRefused
from controller.schema.modes import Law
from controller.schema.parameters import Settings
from controller.schema.slot import PAPER, TUNING
from server.hardware.commissioning import planning
from server.hardware.commissioning.messages import Number
from server.hardware.commissioning.planning import Circle
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found
from server.operate.procedure.motion import POLL_S

SPEED_MAX, ACCELERATION_MAX = 0.05, 0.2
"""Limits of the reference while it lasts [m/s, m/s^2]."""
SPEED = 0.02
"""Along the circle [m/s]."""
ARRIVED_M, SETTLE_S, APPROACH_MAX_S = 2e-3, 2.0, 30.0
"""The reference is in the middle within ARRIVED_M [m], the tip gets SETTLE_S, all of it APPROACH_MAX_S at most [s]."""
RMSE_MAX = 10e-3
"""Of the tip about the reference [m]."""
SATURATED_MAX = 0.05
"""Share of the ticks."""
JUDGED = ("error", "saturated", "residual", "p_meas", "p_ref")
"""What is looked at of telemetry."""
RESIDUAL_SHARE = 0.5
"""Of `limits.residual_max`, for the observer's distance from the markers (rms)."""


def reduced(before: Settings, rods: tuple[int, ...]) -> dict[str, object]:
    """Settings of the first closed loop, where the operator's were `before`: the rods' sensors, half the gains of the
    paper's controller, which needs to know the least about the arm.
    """
    return {
        "law": Law.FF_PI,
        "controller": PAPER,
        "tuning": (0.0,) * TUNING,
        "sensed": sum(1 << (rod - 1) for rod in rods),
        "K_P": (before.K_P[0] / 2, before.K_P[1] / 2),
        "K_I": (before.K_I[0] / 2, before.K_I[1] / 2),
        "speed_max": min(SPEED_MAX, before.speed_max),
        "acceleration_max": min(ACCELERATION_MAX, before.acceleration_max),
    }


async def do(run: StepRun) -> Found:
    """Go to the circle, then around: the first lap is not counted where there are more."""
    circle = await run.parts.planner.do(planning.small_circle, run.parameters)
    laps, rods = run.body.repeats, run.file.motion_capture.rods
    await run.take_rig(**reduced(run.context.operator.settings, rods))
    run.say("goes to the circle's middle")
    await _arrive(circle, run)
    return judged(await _around(circle, laps, run), run.parameters.limits.residual_max, circle)


async def _arrive(circle: Circle, run: StepRun) -> None:
    """Lead the tip to the middle, and give it time to settle."""
    loop = asyncio.get_running_loop()
    end = loop.time() + APPROACH_MAX_S
    await run.target(circle.middle)
    while np.linalg.norm(run.late(POLL_S)["p_ref"][-1] - circle.middle) > ARRIVED_M:
        if loop.time() > end:
            raise CommandRefused(f"the reference did not reach the circle's middle within {APPROACH_MAX_S:g} s")
        await asyncio.sleep(POLL_S)
    await asyncio.sleep(SETTLE_S)


async def _around(circle: Circle, laps: int, run: StepRun) -> Rows:
    """Lead the target `laps` times around; the rows of what counts."""
    loop = asyncio.get_running_loop()
    start, lap = loop.time(), 2.0 * math.pi * circle.radius / SPEED
    counted = run.gather(*JUDGED)
    first = True
    while (passed := loop.time() - start) < laps * lap:
        run.say(f"lap {int(passed / lap) + 1} of {laps}", passed / (laps * lap))
        if first and laps > 1 and passed > lap:
            counted, first = run.gather(*JUDGED), False
        await run.target(place_on(circle, passed))
        await asyncio.sleep(POLL_S)
        counted.take(run.now())
    return counted.rows()


def place_on(circle: Circle, passed: float) -> tuple[float, float]:
    """The target after `passed` [s]: a spiral out within the first eighth, then round."""
    angle = passed * SPEED / circle.radius
    radius = circle.radius * min(1.0, angle / (math.pi / 4.0))
    return circle.middle[0] + radius * math.cos(angle), circle.middle[1] + radius * math.sin(angle)


def judged(rows: Rows, residual_max: float, circle: Circle) -> Found:
    """By the rows of the counted laps."""
    error = np.linalg.norm(rows["error"], axis=1)
    rmse = float(np.sqrt(np.mean(error**2)))
    saturated = float(np.mean(rows["saturated"] != 0))
    sensed = rows["residual"][np.isfinite(rows["residual"])]
    residual = float(np.sqrt(np.mean(sensed**2))) if sensed.size else math.inf
    most = RESIDUAL_SHARE * residual_max
    numbers = (
        _at_most("tip RMSE", rmse, RMSE_MAX, "m"),
        _at_most("largest error", float(error.max()), None, "m"),
        _at_most("saturated", saturated, SATURATED_MAX, "1"),
        _at_most("observer's residual", residual, most, "m"),
    )
    faults = [f"{one.name} is {one.value} {one.unit}, {one.bound}" for one in numbers if not one.kept]
    every = rows[:: max(1, len(rows) // 400)]
    seen = every[np.isfinite(every["p_meas"]).all(axis=1)]
    data: dict[str, JsonValue] = {
        "reference": np.round(seen["p_ref"], 5).tolist(),
        "tip": np.round(seen["p_meas"], 5).tolist(),
    }
    told = f"circle of {circle.radius * 1e3:.0f} mm at half gains: RMSE {rmse * 1e3:.1f} mm"
    text = f"{told}, saturated {saturated:.1%}, residual {residual * 1e3:.1f} mm"
    return Found(not faults, "; ".join(faults) or text, numbers, data=data)


def _at_most(name: str, value: float, most: float | None, unit: str) -> Number:
    known = math.isfinite(value)
    rounded = float(f"{value:.4g}") if known else None
    if most is None:
        return Number(name=name, value=rounded, unit=unit)
    kept = known and value <= most
    return Number(name=name, value=rounded, unit=unit, bound=f"at most {most:g} {unit}", kept=kept)
