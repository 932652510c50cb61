"""The frame step: base, tip at rest and a bent pose tell how the camera lies to the plane. The signs step checks it."""

import asyncio
import math
from collections.abc import Sequence

import numpy as np
from pydantic import JsonValue

from controller.arrays import Array
from controller.errors import CommandRefused, TendrilError
from controller.schema.hardware import Drivers
from server.hardware.commissioning import planning
from server.hardware.commissioning.jog import jog_pressure, jog_torque
from server.hardware.commissioning.messages import PLACES, CaptureBody, Captured, Number, Place, PointName
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found

WINDOW_S, SAMPLE_S = 0.5, 0.02
"""Over which the median of a point is taken, and how often it is looked at [s]."""
SAMPLES_LEAST = 5
SPREAD_MAX = 2e-3
"""Standard deviation of a captured point [m]: beyond, it was moved."""
LENGTH_OFF_MAX = 0.1
"""Share of the actuator's length by which base and tip at rest may be nearer or further."""
BENT_LEAST = 5e-3
"""The bent pose lies at least this far off the line from base to tip [m]."""
BENDS = 2.5
"""For which u1+ is filled before the bent pose is captured [s]."""
IDLE = 600.0
"""Without a capture for so long the step ends [s]."""

SIGN_BENDS, SIGN_RESTS = 2.0, 1.5
"""For how long a chamber is filled, and emptied again [s]."""
TIP_WINDOW = 0.3
"""Over which the tip is averaged [s]."""
MOVES_LEAST = 3e-3
"""Way of the tip along y that tells a sign [m]."""
PAIRS = (("u1+", 0), ("u2+", 2))


class Framing:
    """Captures are asked for by the page, and taken by the step."""

    def __init__(self) -> None:
        self._points: dict[Place, Captured] = {}
        self._asked: asyncio.Queue[tuple[CaptureBody, asyncio.Future[None]]] = asyncio.Queue()

    def captured(self) -> list[Captured]:
        """For the page, in the order in which they are touched."""
        return [self._points[place] for place in PLACES if place in self._points]

    async def capture(self, body: CaptureBody, run: StepRun) -> None:
        """Take one point; raises what is wrong with it, and CommandRefused where the step ends meanwhile."""
        answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._asked.put_nowait((body, answer))
        while not answer.done():
            if not run.running:
                raise CommandRefused(f"the frame step has ended{': ' if run.reason else ''}{run.reason}")
            await asyncio.wait([answer], timeout=0.1)
        answer.result()

    async def do(self, run: StepRun) -> Found:
        """Until all three are captured."""
        rest = await run.parts.planner.do(planning.rest_tip, run.parameters)
        while missing := [place for place in PLACES if place not in self._points]:
            run.say(f"waits for {', '.join(missing)} to be captured", 1.0 - len(missing) / len(PLACES), waits=True)
            try:
                body, answer = await asyncio.wait_for(self._asked.get(), IDLE)
            except TimeoutError as error:
                raise CommandRefused(f"nothing was captured for {IDLE:g} s") from error
            try:
                self._points[body.place] = await self._take(body, run)
            except TendrilError as error:
                if not answer.done():
                    answer.set_exception(error)
            else:
                if not answer.done():
                    answer.set_result(None)
        places = [np.array(self._points[place].at) for place in PLACES]
        return judged_frame(places, run.actuator.length, rest)

    async def _take(self, body: CaptureBody, run: StepRun) -> Captured:
        run.say(f"captures {body.place}", len(self._points) / len(PLACES))
        if body.place != "bent":
            return await _median(body, None, run)
        if "tip" not in self._points:
            raise CommandRefused("capture the tip at rest first: the bent pose is that of the same point")
        await run.take_rig()
        try:
            pressure = jog_pressure(0, run.body.pressure, run.parameters)
            await run.torque(jog_torque(0, pressure, run.parameters))
            near = await _led(np.array(self._points["tip"].at), body.point, run)
            return await _median(body, near, run)
        finally:
            if run.running:
                await run.give_back()


async def _led(start: Array, name: PointName | None, run: StepRun) -> Array | None:
    """Follow the tip's point from `start` (3,) while it bends, where it has no name of its own."""
    if name is not None and not name.startswith("#"):
        await asyncio.sleep(BENDS)
        return None
    loop, at = asyncio.get_running_loop(), start
    end = loop.time() + BENDS
    while loop.time() < end:
        points = points_in(await asyncio.to_thread(run.parts.drivers))
        at = min(points.values(), key=lambda point: float(np.linalg.norm(point - at)), default=at)
        await asyncio.sleep(SAMPLE_S)
    return at


async def _median(body: CaptureBody, near: Array | None, run: StepRun) -> Captured:
    """Median of a point over WINDOW_S: by name, or the one nearest to where it was last."""
    loop, seen, name = asyncio.get_running_loop(), list[Array](), body.point
    end = loop.time() + WINDOW_S
    while loop.time() < end:
        points = points_in(await asyncio.to_thread(run.parts.drivers))
        if near is None:
            name = _chosen(points, name)
            near = points[name]
        one = _followed(points, name, near)
        if one is not None:
            seen.append(one)
            near = one
        await asyncio.sleep(SAMPLE_S)
    return captured(body.place, name or "", seen)


def points_in(found: Drivers) -> dict[str, Array]:
    """What motion capture sees now, by name (3,); CommandRefused without a motion capture that gives points."""
    capture = next((one for one in found.drivers if one.role == "motion_capture"), None)
    if capture is None:
        raise CommandRefused("the rig has no motion capture: its plant is simulated")
    if capture.state != "running":
        raise CommandRefused(f"motion capture ({capture.driver}) is {capture.state}: {capture.detail}")
    places = {}
    for name, values in capture.values.items():
        if len(values) in (2, 3) and all(value is not None for value in values):
            places[name] = np.array([*(value or 0.0 for value in values), 0.0][:3])
    return places


def captured(place: Place, name: str, seen: Sequence[Array]) -> Captured:
    """The median of what was seen (3,); CommandRefused where that is too little, or was moved."""
    if len(seen) < SAMPLES_LEAST:
        raise CommandRefused(
            f"{place}: the point was seen {len(seen)} times in {WINDOW_S:g} s, at least {SAMPLES_LEAST}"
        )
    at = np.median(seen, axis=0)
    spread = float(np.sqrt(((np.array(seen) - at) ** 2).sum(axis=1).mean()))
    if spread > SPREAD_MAX:
        bound = f"at most {SPREAD_MAX:g} m: hold it still"
        raise CommandRefused(f"{place}: the point moved by {spread:.4g} m (rms), {bound}")
    return Captured(place=place, point=name, at=[float(value) for value in at], spread=spread)


def judged_frame(places: Sequence[Array], length: float, rest: tuple[float, float]) -> Found:
    """The frame by base, tip at rest and bent tip (3,) each, with the tip of the model at `rest` (x, y) [m].

    x runs from base to tip (turned by the angle under which the model's tip is seen at rest), y to the side to which
    u1+ bends; rigid, base at (0, 0). Not good where units or pose cannot be right.
    """
    base, tip, bent = places
    apart, wanted = float(np.linalg.norm(tip - base)), math.hypot(*rest)
    numbers = [
        Number(
            name="base to tip at rest",
            value=apart,
            unit="m",
            bound=f"{wanted:.4g} m within {LENGTH_OFF_MAX:.0%}",
            kept=abs(apart - wanted) <= LENGTH_OFF_MAX * wanted,
        )
    ]
    if not numbers[0].kept:
        why = _units(apart, wanted)
        text = f"base and tip at rest are {apart:.4g} m apart, and the actuator's are {wanted:.4g} m: {why}"
        return Found(False, text, tuple(numbers))
    along = (tip - base) / apart
    aside = (bent - base) - ((bent - base) @ along) * along
    off = float(np.linalg.norm(aside))
    bound = f"at least {BENT_LEAST:g} m"
    numbers.append(Number(name="bent pose off the line", value=off, unit="m", bound=bound, kept=off >= BENT_LEAST))
    if off < BENT_LEAST:
        return Found(False, f"the bent pose is {off:.4g} m off the line from base to tip: {bound}", tuple(numbers))
    turn = math.atan2(rest[1], rest[0])
    across = aside / off
    x = math.cos(turn) * along - math.sin(turn) * across
    y = math.sin(turn) * along + math.cos(turn) * across
    axes = np.array([x, y])
    origin = -(axes @ base)
    changes: dict[str, JsonValue] = {
        "motion_capture.frame.axes": [[float(v) for v in row] for row in axes],
        "motion_capture.frame.origin": [float(v) for v in origin],
        "motion_capture.frame.measured": True,
    }
    told = f"base and tip {apart * 1e3:.1f} mm apart (actuator {length * 1e3:.1f} mm)"
    text = f"{told}, u1+ bends {off * 1e3:.1f} mm to +y"
    return Found(True, text, tuple(numbers), changes)


def _followed(points: dict[str, Array], name: PointName | None, near: Array) -> Array | None:
    """The point of this name; of those without one, whose numbers may change, the nearest to where it was."""
    if name is not None and not name.startswith("#"):
        return points.get(name)
    return min(points.values(), key=lambda at: float(np.linalg.norm(at - near)), default=None)


def _units(apart: float, wanted: float) -> str:
    for factor, unit in ((1e-3, "mm"), (1e-2, "cm"), (0.0254, "inches")):
        if abs(apart * factor - wanted) <= LENGTH_OFF_MAX * wanted:
            return f"does the camera measure in {unit}? Set its driver's unit"
    return "are the units right, and was it the tip?"


def _chosen(points: dict[str, Array], name: PointName | None) -> PointName:
    """The name of the point that is meant; CommandRefused where that is not clear."""
    if name is None and len(points) == 1:
        return next(iter(points))
    if name is None or name not in points:
        asked = "no point is named" if name is None else f"there is no point {name}"
        raise CommandRefused(f"{asked}: motion capture sees {', '.join(points) or 'none'}")
    return name


async def signs(run: StepRun) -> Found:
    """Fill u1+, then u2+, and look where the tip goes."""
    await run.take_rig()
    ways = []
    for number, (name, chamber) in enumerate(PAIRS):
        run.say(f"fills {name}", number / len(PAIRS))
        await asyncio.sleep(TIP_WINDOW)
        begin = run.tip(TIP_WINDOW)
        pressure = jog_pressure(chamber, run.body.pressure, run.parameters)
        await run.torque(jog_torque(chamber, pressure, run.parameters))
        await asyncio.sleep(SIGN_BENDS)
        ways.append(run.tip(TIP_WINDOW) - begin)
        await run.torque((0.0, 0.0))
        await asyncio.sleep(SIGN_RESTS)
    return judged_signs(ways)


def judged_signs(ways: list[Array]) -> Found:
    """By the ways (2,) [m] of the tip when u1+ and u2+ were filled."""
    bound = f"at least {MOVES_LEAST:g} m"
    numbers, faults = [], []
    for (name, _), way in zip(PAIRS, ways, strict=True):
        dy = float(way[1])
        numbers.append(Number(name=f"{name}, tip along y", value=dy, unit="m", bound=bound, kept=dy >= MOVES_LEAST))
        if abs(dy) < MOVES_LEAST:
            faults.append(f"{name} moves the tip by {dy * 1e3:.1f} mm along y, at least {MOVES_LEAST * 1e3:g} mm")
        elif dy < 0.0:
            faults.append(f"{name} moves the tip to -y, by {-dy * 1e3:.1f} mm: is it {name[:2]}- that fills?")
    moved = ", ".join(f"{name} {way[1] * 1e3:+.1f} mm" for (name, _), way in zip(PAIRS, ways, strict=True))
    return Found(not faults, "; ".join(faults) or f"tip along y: {moved}", tuple(numbers))
