"""The frame step: base, tip at rest and a bent pose tell how the camera lies to the plane. The signs step checks it.

Units and names are judged before anything moves, by base and tip alone.
"""

import asyncio
import math
from collections.abc import Mapping, Sequence

import numpy as np
from pydantic import JsonValue

from controller.arrays import Array
from controller.errors import CommandRefused, TendrilError
from controller.schema.hardware import Frame
from server.hardware.commissioning import named_markers, planning
from server.hardware.commissioning.jog import SETTLES_S, WAY_ENOUGH, slow_torques
from server.hardware.commissioning.messages import PLACES, CaptureBody, Captured, Number, Place
from server.hardware.commissioning.named_markers import Rest
from server.hardware.commissioning.planning import Believed
from server.hardware.commissioning.points import (
    SAMPLES_LEAST,
    Points,
    captured,
    followed,
    median,
    require_still,
    watched,
)
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found
from server.operate.procedure.motion import POLL_S

LENGTH_OFF_MAX = 0.1
"""Share of the actuator's length by which base and tip at rest may be nearer or further."""
BENT_LEAST = 5e-3
"""The bent pose lies at least this far off the line from base to tip [m]."""
TURNED_LEAST = 20.0
"""An arm never rests quite as its model does: axes that lie nearer to those of the rig file are the same [deg]."""
UNITS = {"mm": 1e-3, "cm": 1e-2, "inches": 0.0254}
IDLE = 600.0
"""Without a capture for so long the step ends [s]."""


class Framing:
    """Captures are asked for by the page, and taken by the step."""

    def __init__(self) -> None:
        self._points: dict[Place, Captured] = {}
        self._named: dict[str, Array] = {}
        """Every marker with a name, as the tip at rest was captured (3,)."""
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
        """Until all three are captured, or base and tip show that units or names are wrong."""
        believed = await run.parts.planner.do(planning.believed, run.parameters)
        while missing := [place for place in PLACES if place not in self._points]:
            run.say(f"waits for {', '.join(missing)} to be captured", 1.0 - len(missing) / len(PLACES), waits=True)
            try:
                body, answer = await asyncio.wait_for(self._asked.get(), IDLE)
            except TimeoutError as error:
                raise CommandRefused(f"nothing was captured for {IDLE:g} s") from error
            try:
                self._points[body.place] = await self._take(body, run, believed)
                fault = self._fault_at_rest(run, believed)
            except TendrilError as error:
                if not answer.done():
                    answer.set_exception(error)
                continue
            if not answer.done():
                answer.set_result(None)
            if fault is not None:
                return fault
        asked = run.file.motion_capture
        bent = np.array(self._points["bent"].at)
        return judged_frame(self._rest(), bent, believed, asked.labels, asked.frame)

    def _rest(self) -> Rest:
        return Rest(np.array(self._points["base"].at), np.array(self._points["tip"].at), self._named)

    def _fault_at_rest(self, run: StepRun, believed: Believed) -> Found | None:
        """What base and tip show to be wrong; CommandRefused where one of them was moved, and is to be taken again."""
        if not {"base", "tip"} <= set(self._points):
            return None
        found = judged_rest(self._rest(), believed, run.file.motion_capture.labels)
        if not found.good:
            return found
        for place in ("base", "tip"):
            try:
                require_still(self._points[place])
            except CommandRefused:
                del self._points[place]
                raise
        return None

    async def _take(self, body: CaptureBody, run: StepRun, believed: Believed) -> Captured:
        run.say(f"captures {body.place}", len(self._points) / len(PLACES))
        if body.place == "bent":
            return await self._bent(body, run, believed)
        looks = await watched(run.parts.drivers)
        if body.place == "tip":
            self._named = named_in(looks, run.file.motion_capture.labels)
        return captured(body, looks)

    async def _bent(self, body: CaptureBody, run: StepRun, believed: Believed) -> Captured:
        """u1+ fills slowly, until the tip's point has gone far enough."""
        if missing := [place for place in ("tip", "base") if place not in self._points]:
            raise CommandRefused(f"capture the {missing[0]} at rest first: the bent pose is that of the same point")
        start = np.array(self._points["tip"].at)
        await run.take_rig()
        try:
            at = start
            for u in slow_torques(0, run, believed):
                await run.torque(u)
                await asyncio.sleep(POLL_S)
                at = await followed(run.parts.drivers, body.point, at)
                if np.linalg.norm(at - start) >= WAY_ENOUGH:
                    break
            await asyncio.sleep(SETTLES_S)
            bent = captured(body, await watched(run.parts.drivers), at)
            require_still(bent)
            run.keep_pair("tip, u1+ filled, as the camera sees it", start, np.array(bent.at), "m")
            return bent
        finally:
            if run.running:
                await run.give_back()


def named_in(looks: Sequence[Points], labels: Mapping[str, int]) -> dict[str, Array]:
    """Medians of the markers of `labels` (3,), of those that were seen often enough."""
    seen = {name: [points[name] for points in looks if name in points] for name in labels}
    return {name: np.array(median("tip", name, at).at) for name, at in seen.items() if len(at) >= SAMPLES_LEAST}


def judged_rest(rest: Rest, believed: Believed, labels: Mapping[str, int]) -> Found:
    """By what was seen at rest: units, and whether every marker with a name lies where its rod does."""
    apart, wanted = float(np.linalg.norm(rest.tip - rest.base)), math.hypot(*believed.rods[-1])
    off = abs(apart - wanted)
    bound = f"{wanted:.4g} m within {LENGTH_OFF_MAX:.0%}"
    length = Number(name="base to tip at rest", value=apart, unit="m", bound=bound, kept=off <= LENGTH_OFF_MAX * wanted)
    if apart == 0.0:
        return Found(False, "base and tip at rest are one and the same point", (length,))
    as_believed = named_markers.placed(rest, believed.rods, labels, 1.0)
    scaled = named_markers.placed(rest, believed.rods, labels, apart / wanted)
    told = (length, *named_markers.numbers(scaled if length.kept else as_believed, wanted))
    if swapped := named_markers.swapped(as_believed) or named_markers.swapped(scaled):
        return Found(False, swapped, told)
    if not length.kept:
        why = _units(apart, wanted)
        text = f"base and tip at rest are {apart:.4g} m apart, and the actuator's are {wanted:.4g} m: {why}"
        return Found(False, text, (length,))
    if misplaced := named_markers.misplaced(scaled, labels, wanted):
        return Found(False, misplaced, told)
    return Found(True, f"base and tip {apart * 1e3:.1f} mm apart (actuator {wanted * 1e3:.1f} mm)", told)


def judged_frame(rest: Rest, bent: Array, believed: Believed, labels: Mapping[str, int], before: Frame) -> Found:
    """The frame by what was seen at rest, and the bent tip (3,); `before` is that of the rig file.

    x runs from base to tip (turned by the angle under which the model's tip is seen at rest), y to the side to which
    u1+ bends; rigid, base at (0, 0). Not good where units, names or pose cannot be right.
    """
    found = judged_rest(rest, believed, labels)
    if not found.good:
        return found
    apart = float(np.linalg.norm(rest.tip - rest.base))
    along = (rest.tip - rest.base) / apart
    aside = (bent - rest.base) - ((bent - rest.base) @ along) * along
    off = float(np.linalg.norm(aside))
    bound = f"at least {BENT_LEAST:g} m"
    kept = off >= BENT_LEAST
    numbers = (*found.numbers, Number(name="bent pose off the line", value=off, unit="m", bound=bound, kept=kept))
    if not kept:
        return Found(False, f"the bent pose is {off:.4g} m off the line from base to tip: {bound}", numbers)
    turn = math.atan2(believed.rods[-1, 1], believed.rods[-1, 0])
    across = aside / off
    x = math.cos(turn) * along - math.sin(turn) * across
    y = math.sin(turn) * along + math.cos(turn) * across
    axes = np.array([x, y])
    origin = -(axes @ rest.base)
    changes: dict[str, JsonValue] = {
        "motion_capture.frame.axes": [[float(v) for v in row] for row in axes],
        "motion_capture.frame.origin": [float(v) for v in origin],
        "motion_capture.frame.measured": True,
    }
    text = f"{found.text}, u1+ bends {off * 1e3:.1f} mm to +y{turned(before, axes)}"
    return Found(True, text, numbers, changes)


def turned(before: Frame, axes: Array) -> str:
    """How the axes of the rig file lay to those that were found (2,3), as "; ..."; "" where they are the same."""
    said = np.array(before.axes)
    said /= np.linalg.norm(said, axis=1)[:, None]
    x, y = (math.degrees(math.acos(max(-1.0, min(1.0, float(a @ b))))) for a, b in zip(said, axes, strict=True))
    same, opposite = TURNED_LEAST, 180.0 - TURNED_LEAST
    if x < same and y < same:
        return ""
    if x < same and y > opposite:
        return "; y of the rig file was mirrored"
    if x > opposite and y < same:
        return "; x of the rig file was mirrored"
    if x > opposite and y > opposite:
        return "; the rig file had the camera upside down"
    return f"; x of the rig file was {x:.0f} degrees off, y {y:.0f}"


def _units(apart: float, wanted: float) -> str:
    for unit, metres in UNITS.items():
        if abs(apart * metres - wanted) <= LENGTH_OFF_MAX * wanted:
            return f"does the camera measure in {unit}? Set its driver's unit"
    if abs(1e3 * apart - wanted) <= LENGTH_OFF_MAX * wanted:
        return "is its driver's unit 1000 times too small?"
    return "are the units right, and was it the tip?"
