"""The signs step: whether u1+ and u2+ move the tip to where the frame has +y, and what the ways exclude if not.

Each way is measured from rest, and beside how far the tip drifts by itself in as long.
"""

import asyncio
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import CommandRefused
from server.hardware.commissioning import planning
from server.hardware.commissioning.jog import RISE_SHARE, SETTLES_S, WAY_ENOUGH, pressure_of, slow_torques
from server.hardware.commissioning.messages import CHAMBERS, Chamber, Number
from server.hardware.commissioning.planning import Believed
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found
from server.operate.procedure.motion import POLL_S

FILLED: tuple[Chamber, ...] = ("u1+", "u2+")
STILL = 5e-4
"""The arm rests where its tip swings by less (rms) [m]."""
REST_MIN_S, REST_MAX_S = 0.8, 20.0
"""It is waited for so long at least, and at most [s]."""
DRIFT_S = 1.5
"""Over which the drift at rest is measured [s]."""
TIP_WINDOW_S = 0.3
"""Over which tip and pressures are averaged [s]."""
MOVES_LEAST = 3e-3
"""Way of the tip along y that tells a sign [m]."""
DRIFT_SPEED = 2e-4
"""A tip that creeps back from the push before is waited for until it is slower than this [m/s]."""
DRIFT_TIMES = 3.0
"""It is so many times what the tip drifts by itself in as long."""
ALIKE = 1.5
"""Pairs that move the tip more alike than this, by the model, are not told apart by how far they do."""


class Push(NamedTuple):
    """One chamber filled from rest, and what came of it."""

    chamber: Chamber
    before: Array
    """Tip (2,) [m]."""
    after: Array
    asked: float
    """Pressure [Pa]."""
    rise: float
    """Of its own sensor [Pa]."""
    drift: float
    """By which the tip alone would have moved in as long [m]."""

    @property
    def dy(self) -> float:
        """Way of the tip along y [m]."""
        return float(self.after[1] - self.before[1])


async def do(run: StepRun) -> Found:
    """Fill u1+, then u2+, each from rest, and look where the tip goes."""
    believed = await run.parts.planner.do(planning.believed, run.parameters)
    await run.take_rig()
    pushes = []
    for number, chamber in enumerate(FILLED):
        share = number / len(FILLED)
        run.say("waits for the arm to rest", share)
        speed = await _drift(run)
        run.say(f"fills {chamber}", share)
        pushes.append(await _push(chamber, speed, run, believed))
        await run.torque((0.0, 0.0))
    return judged_signs(pushes, believed.ways)


async def _drift(run: StepRun) -> float:
    """Speed of the tip at rest [m/s]; CommandRefused where it does not come to rest."""
    if not await run.still(REST_MIN_S, REST_MAX_S, STILL):
        raise CommandRefused(f"the tip swings by more than {STILL * 1e3:g} mm (rms), {REST_MAX_S:g} s without pressure")
    clock = asyncio.get_running_loop().time
    end = clock() + REST_MAX_S
    while True:
        begin = run.tip(TIP_WINDOW_S)
        await asyncio.sleep(DRIFT_S)
        speed = float(np.linalg.norm(run.tip(TIP_WINDOW_S) - begin)) / DRIFT_S
        if speed < DRIFT_SPEED or clock() > end:
            return speed


async def _push(chamber: Chamber, speed: float, run: StepRun, believed: Believed) -> Push:
    """Fill `chamber` slowly, until the tip has gone far enough; it drifts at `speed` [m/s] by itself."""
    index, clock = CHAMBERS.index(chamber), asyncio.get_running_loop().time
    begin, before, empty = clock(), run.tip(TIP_WINDOW_S), run.pressures(TIP_WINDOW_S)
    u = (0.0, 0.0)
    for u in slow_torques(index, run, believed):
        await run.torque(u)
        await asyncio.sleep(POLL_S)
        if np.linalg.norm(run.tip(TIP_WINDOW_S) - before) >= WAY_ENOUGH:
            break
    await asyncio.sleep(SETTLES_S)
    after, full = run.tip(TIP_WINDOW_S), run.pressures(TIP_WINDOW_S)
    run.keep_pair(f"tip, {chamber} filled", before, after, "m")
    run.keep_pair(f"pressures, {chamber} filled", empty, full, "Pa")
    rise = float(full[index] - empty[index])
    return Push(chamber, before, after, pressure_of(u, run.parameters), rise, speed * (clock() - begin))


def judged_signs(pushes: Sequence[Push], ways: tuple[float, float]) -> Found:
    """By how u1+ and u2+ moved the tip; `ways` [m/Pa] are those of the model.

    A cause is named only where these ways exclude the others, and none at all for a way that may be drift.
    """
    bound = f"at least {MOVES_LEAST:g} m, and {DRIFT_TIMES:g} times the drift"
    numbers = list[Number]()
    for one in pushes:
        least = max(MOVES_LEAST, DRIFT_TIMES * one.drift)
        name = f"{one.chamber}, tip along y"
        numbers += [
            Number(name=name, value=one.dy, unit="m", bound=bound, kept=one.dy >= least),
            Number(name=f"{one.chamber}, drift in as long", value=one.drift, unit="m"),
            Number(name=f"{one.chamber}, rise of its sensor", value=one.rise, unit="Pa"),
        ]
    moved = ", ".join(f"{one.chamber} {one.dy * 1e3:+.1f} mm" for one in pushes)
    text = f"tip along y: {moved}"
    fault = "; ".join(filter(None, map(_untold, pushes))) or _cause(pushes, ways)
    return Found(not fault, f"{text}: {fault}" if fault else text, tuple(numbers))


def _untold(push: Push) -> str:
    """Why its way tells no sign; "" where it does."""
    way = abs(push.dy)
    if way >= MOVES_LEAST and way < DRIFT_TIMES * push.drift:
        return f"{push.chamber} tells no sign, the tip drifts by {push.drift * 1e3:.1f} mm in as long"
    if way >= MOVES_LEAST:
        return ""
    sensor = f"its sensor rose by {push.rise * 1e-3:.1f} kPa of {push.asked * 1e-3:.1f}"
    filled = ": it did not fill" if push.rise < RISE_SHARE * push.asked else ""  # a sensor that shows nothing tells not
    return f"{push.chamber} moves the tip by less than {MOVES_LEAST * 1e3:g} mm along y, {sensor}{filled}"


def _cause(pushes: Sequence[Push], ways: tuple[float, float]) -> str:
    """What is wrong with signs that are told; "" where nothing is."""
    right = [one.dy > 0.0 for one in pushes]
    if not any(right):
        return "y of the frame is mirrored, or two chambers of each pair are exchanged: do Frame again"
    if not all(right):
        return "two chambers are exchanged, and these ways do not tell which: see in Chambers which one fills"
    first, second = (float(np.linalg.norm(one.after - one.before)) / one.asked for one in pushes)
    found, model = math.log(first / second), math.log(ways[0] / ways[1])
    if abs(model) < math.log(ALIKE) or found * model >= 0.0:
        return ""
    told = f"u1+ moves it by {first * 1e6:.2g} mm/kPa and u2+ by {second * 1e6:.2g}"
    wanted = f"where the actuator's do by {ways[0] * 1e6:.2g} and {ways[1] * 1e6:.2g}"
    return f"{told}, {wanted}: u1+ and u2+ are exchanged, or this is another actuator"
