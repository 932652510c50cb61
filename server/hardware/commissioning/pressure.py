"""The pressure step: each chamber steps up and down; dead time and lag follow, before them the loop of raw valves."""

import asyncio
from collections.abc import Sequence

import numpy as np
from pydantic import JsonValue

from controller.errors import ParameterError
from controller.schema.hardware import PressureLoop, Valves
from controller.schema.modes import Cause
from controller.schema.parameters import RigParameters
from server.hardware.commissioning import planning
from server.hardware.commissioning.jog import jog_torque
from server.hardware.commissioning.messages import CHAMBERS, Number, StepName
from server.hardware.commissioning.planning import PressureFit, PressureSteps, RawLoop
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found
from server.operate.procedure.motion import POLL_S

USUAL, SHARE_MAX = 80e3, 0.5
"""Largest pressure of a step [Pa], and its bound as a share of that of full torque."""
LEVELS = (1.0, 1 / 3, 2 / 3, 0.0)
"""Of that, one after another."""
HOLD_MIN_S, HOLD_MAX_S = 0.8, 4.0
"""Each of them at least, and at most until the chamber stands still [s]."""
STILL, WINDOW = 300.0, 0.3
"""It does where the second half of WINDOW [s] differs from the first by less [Pa], on average."""
RESIDUAL_MAX, RESIDUAL_LEAST = 0.12, 5e3
"""What dead time and lag may leave over, as a share of the largest step; in small steps, which exhaust more slowly than
they fill, this [Pa]."""
GAIN_OFF_MAX = 0.15
"""By how much a chamber at rest may be off its setpoint, as a share."""
ZERO_MAX = 5e3
"""What a sensor may show of an open chamber [Pa]."""
FIRST_LEVELS, FIRST_SHARE = (1.0, 0.0), 0.9
"""Of raw valves, whose loop may be far off: one step up and down, by this share of `limits.pressure_off_max` at most.
However slowly the chamber follows, or however far it swings beyond, that is no E-STOP before it is seen."""
LOOP_SAME = 0.15
"""A loop whose numbers are all within this share of those that are wanted stays as it is."""
PHASE_LEAST = 40.0
"""Phase margin of the loop of raw valves [deg]; its delay may be longer by half at least before it swings."""
MARGIN_SHARE = 0.5


def step_pressure(asked: float | None, rig: RigParameters) -> float:
    """Pressure of the largest step [Pa], within its bound; ParameterError where more is asked for."""
    full = rig.actuator.u_max * min(rig.actuator.pressure_map)
    if asked is not None and asked > SHARE_MAX * full:
        raise ParameterError(f"pressure = {asked:g} Pa is above {SHARE_MAX * full:.0f} Pa, half of full torque's")
    return min(USUAL, SHARE_MAX * full) if asked is None else asked


async def do(run: StepRun) -> Found:
    """Steps in all four chambers, then the fit; before that the loop of raw valves is seen to."""
    level = step_pressure(run.body.pressure, run.parameters)
    valves, raw = run.file.valves, None
    await run.take_rig()
    if valves.command == "opening":
        first = min(level, FIRST_SHARE * run.parameters.limits.pressure_off_max)
        steps = await _all_steps(first, FIRST_LEVELS, run)
        run.say("finds the valves", 1.0)
        raw = await run.parts.planner.do(planning.raw_loop, steps, valves, run.parameters)
        if not same_loop(valves.loop, raw.wanted):
            return proposed(raw)
    steps = await _all_steps(level, LEVELS * run.body.repeats, run)
    run.has_rig = False
    await run.give_back()
    run.say("finds dead time and lag", 1.0)
    fit = await run.parts.planner.do(planning.pressure_fit, steps, run.parameters)
    return judged(fit, level, raw)


async def _all_steps(level: float, levels: Sequence[float], run: StepRun) -> tuple[PressureSteps, ...]:
    """One chamber after another."""
    return tuple([await _steps(chamber, level, levels, run) for chamber in range(len(CHAMBERS))])


async def _steps(chamber: int, level: float, levels: Sequence[float], run: StepRun) -> PressureSteps:
    """Those of one chamber, to `levels` of `level` [Pa]."""
    await asyncio.sleep(HOLD_MIN_S / 2)
    seen, starts = run.gather("slot", "pressure_cmd", "pressure_meas"), []
    await asyncio.sleep(HOLD_MIN_S / 2)
    for number, share in enumerate(levels):
        run.say(f"steps {CHAMBERS[chamber]}", (chamber + number / len(levels)) / len(CHAMBERS))
        starts.append(run.slot())
        await run.torque(jog_torque(chamber, share * level, run.parameters))
        await _hold(chamber, run)
        seen.take(run.now())
    rows = seen.rows()
    asked, shown = rows["pressure_cmd"][:, chamber], rows["pressure_meas"][:, chamber]
    return PressureSteps(rows["slot"].copy(), asked.copy(), shown.copy(), tuple(starts))


async def _hold(chamber: int, run: StepRun) -> None:
    """A step lasts until its chamber stands still: a slow one would else seem to stop short of its setpoint."""
    await asyncio.sleep(HOLD_MIN_S)
    for _ in range(int((HOLD_MAX_S - HOLD_MIN_S) / POLL_S)):
        p = run.late(WINDOW)["pressure_meas"][:, chamber]
        if abs(p[len(p) // 2 :].mean() - p[: len(p) // 2].mean()) < STILL:
            return
        await asyncio.sleep(POLL_S)


def same_loop(one: PressureLoop, other: PressureLoop) -> bool:
    """Whether no number of one differs by more than LOOP_SAME from the other's."""
    wanted, found = other.model_dump(), one.model_dump()
    return all(abs(found[name] - value) <= LOOP_SAME * value for name, value in wanted.items())


def proposed(raw: RawLoop) -> Found:
    """Other gains for the loop of raw valves: they are accepted, and the chambers step once more."""
    loop = raw.wanted.model_dump()
    told = f"the valves answer after {raw.delay * 1e3:.0f} ms: gains of their loop are proposed"
    changes: dict[str, JsonValue] = {f"valves.loop.{name}": value for name, value in loop.items()}
    return Found(True, f"{told}; accept them, and step once more", raw_numbers(raw, 1), changes, again=True)


def raw_numbers(raw: RawLoop, loop: int) -> tuple[Number, ...]:
    """What was found of raw valves; with the margins of their loop in force (0), or of the one that is wanted (1)."""
    phase, margin, least = raw.phase[loop], raw.margin[loop], MARGIN_SHARE * raw.delay
    bounds = f"at least {PHASE_LEAST:g} deg", f"at least {least:.3g} s"
    rates = (("filling", raw.fill), ("exhausting from 60 kPa", raw.exhaust))
    return (
        Number(name="delay of the valves", value=raw.delay, unit="s"),
        *(
            Number(name=f"{name}, wholly open, {which}", value=value, unit="Pa/s")
            for name, each in rates
            for which, value in (("slowest", min(each)), ("fastest", max(each)))
        ),
        Number(name="phase margin", value=phase, unit="deg", bound=bounds[0], kept=phase >= PHASE_LEAST),
        Number(name="delay margin", value=margin, unit="s", bound=bounds[1], kept=margin >= least),
    )


def judged(fit: PressureFit, level: float, raw: RawLoop | None = None) -> Found:
    """What the fit means for the rig file, for steps of up to `level` [Pa]; `raw` of valves that take openings."""
    numbers = [
        Number(name=name, value=value, unit="s", low=low, high=high)
        for name, (value, low, high) in (
            ("dead time", fit.dead_time),
            ("lag", fit.lag),
            ("lag, filling", fit.inflate),
            ("lag, exhausting", fit.exhaust),
        )
    ]
    most = max(RESIDUAL_LEAST, RESIDUAL_MAX * level)
    numbers.append(_within("residual", fit.residual, "Pa", most, 0.0))
    for name, gain, zero in zip(CHAMBERS, fit.gains, fit.zeros, strict=True):
        numbers += [_within(f"{name}, gain", gain, "1", GAIN_OFF_MAX, 1.0)]
        numbers += [_within(f"{name}, at zero", zero, "Pa", ZERO_MAX, 0.0)]
    if raw is not None:
        numbers += raw_numbers(raw, 0)
    data: dict[str, JsonValue] = {"curves": [np.round(curve, 4).tolist() for curve in fit.curves]}
    faults = [f"{one.name} is {one.value:.4g} {one.unit}: {one.bound}" for one in numbers if not one.kept]
    if faults:
        return Found(False, "; ".join(faults), tuple(numbers), data=data)
    changes: dict[str, JsonValue] = {
        "controller.dead_time": round(fit.dead_time[0], 4),
        "controller.pneumatic_lag": round(fit.lag[0], 4),
        "valves.measured": True,
    }
    told = f"dead time {fit.dead_time[0] * 1e3:.0f} ms, lag {fit.lag[0] * 1e3:.0f} ms"
    apart = f"filling {fit.inflate[0] * 1e3:.0f} ms, exhausting {fit.exhaust[0] * 1e3:.0f} ms"
    return Found(True, f"{told} ({apart})", tuple(numbers), changes, data)


def advice(step: StepName, cause: Cause, valves: Valves) -> str:
    """What to do where pressures that are off what the loop believes have ended `step`; "" where that is not known."""
    if cause != Cause.PRESSURE_MISMATCH:
        return ""
    if valves.command == "opening":
        return ": if the pressure swings, divide the gains of valves.loop by 3 in the rig file"
    return ": slow chambers? Step by 25 kPa, accept that, and step once more" if step == "pressure" else ""


def _within(name: str, value: float, unit: str, most: float, around: float) -> Number:
    bound = f"at most {most:.4g} {unit}" if around == 0.0 else f"{around:g} within {most:g}"
    return Number(name=name, value=value, unit=unit, bound=bound, kept=abs(value - around) <= most)
