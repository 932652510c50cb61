"""The pressure step: each chamber steps up and down, and dead time, lag and the gains of raw valves follow."""

import asyncio

import numpy as np
from pydantic import JsonValue

from controller.errors import ParameterError
from controller.schema.hardware import PressureLoop, Valves
from controller.schema.parameters import RigParameters
from server.commissioning import planning
from server.commissioning.jog import jog_torque
from server.commissioning.messages import CHAMBERS, Number
from server.commissioning.motion import Motion, Run, Through
from server.commissioning.planning import PressureFit, PressureSteps
from server.commissioning.store import Found

USUAL, SHARE_MAX = 80e3, 0.5
"""Largest pressure of a step [Pa], and its bound as a share of that of full torque."""
LEVELS = (1.0, 1 / 3, 2 / 3, 0.0)
"""Of that, one after another."""
HOLDS = 0.8
"""Each of them [s]."""
RESIDUAL_MAX = 0.12
"""What dead time and lag may leave over, as a share of the largest step."""
GAIN_OFF_MAX = 0.15
"""By how much a chamber at rest may be off its setpoint, as a share."""
OFFSET_MAX = 5e3
"""What a sensor may show of an open chamber [Pa]."""
LAG_WANTED, LAG_PER_DEAD_TIME = 0.03, 2.0
"""The lag that a loop of raw valves is to have: this [s], but this many dead times at least, or it swings."""
GAIN_STEP = 3.0
"""Most by which a gain changes at once."""
GAIN_SAME = 0.15
"""A change of gain smaller than this share is none."""


def step_pressure(asked: float | None, rig: RigParameters) -> float:
    """Pressure of the largest step [Pa], within its bound; ParameterError where more is asked for."""
    full = rig.actuator.u_max * min(rig.actuator.pressure_map)
    if asked is not None and asked > SHARE_MAX * full:
        raise ParameterError(f"pressure = {asked:g} Pa is above {SHARE_MAX * full:.0f} Pa, half of full torque's")
    return min(USUAL, SHARE_MAX * full) if asked is None else asked


async def do(run: Run, motion: Motion, through: Through) -> Found:
    """Steps in all four chambers, then the fit."""
    level = step_pressure(run.body.pressure, run.parameters)
    await motion.begin()
    steps = []
    for chamber in range(len(CHAMBERS)):
        steps.append(await _steps(chamber, level, run, motion))
    run.moves = False
    await motion.end()
    run.say("finds dead time and lag", 1.0)
    fit = await through.planner.do(planning.pressure_fit, tuple(steps), run.parameters)
    return judged(fit, level, run.file.valves)


async def _steps(chamber: int, level: float, run: Run, motion: Motion) -> PressureSteps:
    """Those of one chamber."""
    levels = LEVELS * run.body.repeats
    await asyncio.sleep(HOLDS / 2)
    begin, starts = motion.now(), []
    await asyncio.sleep(HOLDS / 2)
    for number, share in enumerate(levels):
        run.say(f"steps {CHAMBERS[chamber]}", (chamber + number / len(levels)) / len(CHAMBERS))
        starts.append(motion.slot())
        await motion.torque(jog_torque(chamber, share * level, run.parameters))
        await asyncio.sleep(HOLDS)
    rows = motion.between(begin, motion.now())
    asked, shown = rows["pressure_cmd"][:, chamber], rows["pressure_meas"][:, chamber]
    return PressureSteps(rows["slot"].copy(), asked.copy(), shown.copy(), tuple(starts))


def judged(fit: PressureFit, level: float, valves: Valves) -> Found:
    """What the fit means for the rig file, for steps of up to `level` [Pa]."""
    numbers = [
        Number(name=name, value=value, unit="s", low=low, high=high)
        for name, (value, low, high) in (
            ("dead time", fit.dead_time),
            ("lag", fit.lag),
            ("lag, filling", fit.inflate),
            ("lag, exhausting", fit.exhaust),
        )
    ]
    most = RESIDUAL_MAX * level
    numbers.append(_within("residual", fit.residual, "Pa", most, 0.0))
    for name, gain, offset in zip(CHAMBERS, fit.gains, fit.offsets, strict=True):
        numbers += [_within(f"{name}, gain", gain, "1", GAIN_OFF_MAX, 1.0)]
        numbers += [_within(f"{name}, at zero", offset, "Pa", OFFSET_MAX, 0.0)]
    data: dict[str, JsonValue] = {"curves": [np.round(curve, 4).tolist() for curve in fit.curves]}
    faults = [f"{one.name} is {one.value:.4g} {one.unit}: {one.bound}" for one in numbers if not one.kept]
    if faults:
        return Found(False, "; ".join(faults), tuple(numbers), data=data)
    gains = tuned(valves.loop, fit) if valves.command == "opening" else {}
    told = f"dead time {fit.dead_time[0] * 1e3:.0f} ms, lag {fit.lag[0] * 1e3:.0f} ms"
    if gains:
        text = f"{told}; other gains of the valves' loop are proposed: accept them, and step once more"
        return Found(True, text, tuple(numbers), gains, data, again=True)
    changes: dict[str, JsonValue] = {
        "controller.dead_time": round(fit.dead_time[0], 4),
        "controller.pneumatic_lag": round(fit.lag[0], 4),
        "valves.measured": True,
    }
    apart = f"filling {fit.inflate[0] * 1e3:.0f} ms, exhausting {fit.exhaust[0] * 1e3:.0f} ms"
    return Found(True, f"{told} ({apart})", tuple(numbers), changes, data)


def tuned(loop: PressureLoop, fit: PressureFit) -> dict[str, JsonValue]:
    """Gains by which filling and exhausting get the lag that is wanted; nothing where they have it already.

    A chamber behind a valve integrates its opening, so the lag of the loop falls as its gain rises: tau gain = const.
    """
    wanted = max(LAG_WANTED, LAG_PER_DEAD_TIME * fit.dead_time[0])
    changes: dict[str, JsonValue] = {}
    for name, gain, lag in (
        ("inflate_gain", loop.inflate_gain, fit.inflate[0]),
        ("exhaust_gain", loop.exhaust_gain, fit.exhaust[0]),
    ):
        factor = min(GAIN_STEP, max(1.0 / GAIN_STEP, lag / wanted))
        if abs(factor - 1.0) > GAIN_SAME:
            changes[f"valves.loop.{name}"] = float(f"{gain * factor:.3g}")
    return changes


def _within(name: str, value: float, unit: str, most: float, around: float) -> Number:
    bound = f"at most {most:.4g} {unit}" if around == 0.0 else f"{around:g} within {most:g}"
    return Number(name=name, value=value, unit=unit, bound=bound, kept=abs(value - around) <= most)
