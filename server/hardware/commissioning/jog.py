"""The jog step: one chamber at low pressure while a button is held, and which one then fills, by sensor and by eye."""

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import CommandRefused
from controller.schema.parameters import RigParameters
from server.hardware.commissioning import planning
from server.hardware.commissioning.messages import CHAMBERS, Chamber, Jogged, JogView, Number
from server.hardware.commissioning.planning import Believed
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found, numbers_of
from server.operate.procedure.motion import POLL_S, Torques

RENEWED = 0.4
"""A held button counts for so long [s]."""
PRESSURE_MAX, SHARE_MAX = 40e3, 0.2
"""A jogged chamber gets at most this [Pa], and this share of the pressure of full torque."""
WAY_SPEED, WAY_ENOUGH = 0.01, 0.015
"""Where the tip is watched while a chamber fills: it is to go so fast [m/s], and so far off its rest [m]."""
SETTLES_S = 1.0
"""For how long it is waited for then [s]."""
WATCHED_SHARE = 0.45
"""Of `limits.pressure_off_max` while the chambers are unknown: beyond half of it a wrong chamber would be an E-STOP."""
MOVED_MAX, PRESSURE_LEAST = 0.02, 4e3
"""While the chambers are unknown, the model's tip goes no further than this, whichever fills [m]; but this pressure is
had at least, of which a sensor can tell half from an empty chamber [Pa]."""
FILL_S = 0.5
"""Over which a jogged chamber is filled: at once, an arm that hardly damps would swing twice as far [s]."""
SETTLED, WINDOW = 0.8, 0.2
"""How long a full chamber is held before its pressures are looked at, and over which they are averaged [s]."""
HELD_S = FILL_S + SETTLED + WINDOW
RISE_SHARE = 0.5
"""A sensor has risen where it shows this share of what was commanded more."""
IDLE = 120.0
"""Without a button held for so long the step ends [s]."""


def jog_pressure(chamber: int, asked: float | None, rig: RigParameters) -> float:
    """Pressure of a chamber [Pa], within its bounds."""
    full = rig.actuator.u_max * float(rig.actuator.chamber_slopes[chamber])
    most = min(PRESSURE_MAX, SHARE_MAX * full)
    return most if asked is None else min(most, asked)


def first_pressure(chamber: int, asked: float | None, rig: RigParameters, believed: Believed) -> float:
    """The same while the chambers' order is unknown [Pa]: any of them may fill, and move the tip by so much."""
    moves = max(PRESSURE_LEAST, MOVED_MAX / max(believed.ways))
    return min(jog_pressure(chamber, asked, rig), moves, WATCHED_SHARE * rig.limits.pressure_off_max)


def jog_torque(chamber: int, pressure: float, rig: RigParameters) -> Torques:
    """Torques [N m] by which `chamber` (0 to 3) alone is filled to `pressure` [Pa]."""
    u = (pressure if chamber % 2 == 0 else -pressure) / float(rig.actuator.chamber_slopes[chamber])
    return (u, 0.0) if chamber < 2 else (0.0, u)


def pressure_of(u: Torques, rig: RigParameters) -> float:
    """Of the fullest chamber at torques `u` [Pa]."""
    slopes = rig.actuator.chamber_slopes
    return max(abs(one) * float(slopes[2 * j + int(one < 0.0)]) for j, one in enumerate(u))


def slow_torques(chamber: int, run: StepRun, believed: Believed) -> list[Torques]:
    """One each POLL_S, by which `chamber` fills to its bound, so slowly that who watches the tip can stop in time."""
    full = jog_pressure(chamber, run.body.pressure, run.parameters)
    steps = math.ceil(full * believed.ways[chamber // 2] / (WAY_SPEED * POLL_S))
    return [jog_torque(chamber, float(p), run.parameters) for p in np.linspace(0.0, full, steps + 1)[1:]]


class _Press(NamedTuple):
    """One chamber from press to release."""

    chamber: int
    since: float
    share: float = 0.0
    """Of its pressure that was asked for."""
    shown: Array | None = None
    """What was measured of it, full (4,) [Pa]."""


class Jogging:
    """Holds are renewed by the page; only the event loop uses it."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._held: int | None = None
        self._until, self._last = 0.0, now()
        self._pressure = 0.0
        self._measured: Array | None = None
        self._empty: Array | None = None
        """The least pressures that were measured as a button was pressed (4,) [Pa]."""
        self._jogged: dict[Chamber, Jogged] = {}

    def hold(self, chamber: Chamber | None) -> None:
        """The button of `chamber` is held, for another RENEWED; None: it was released."""
        self._last = self._now()
        self._held = None if chamber is None else CHAMBERS.index(chamber)
        self._until = self._last + RENEWED

    def held(self) -> int | None:
        """The chamber that may be filled now."""
        return self._held if self._now() < self._until else None

    def confirm(self, commanded: Chamber, filled: Chamber) -> None:
        """The operator saw `filled` fill; CommandRefused unless `commanded` was jogged."""
        if (one := self._jogged.get(commanded)) is None:
            raise CommandRefused(f"{commanded} was not jogged yet: hold its button for {HELD_S:g} s")
        self._last = self._now()
        self._jogged[commanded] = one.model_copy(update={"filled": filled})

    def view(self) -> JogView:
        """For the page."""
        held = self.held()
        return JogView(
            held=None if held is None else CHAMBERS[held],
            pressure=self._pressure,
            pressures=[None] * 4 if self._measured is None else numbers_of(self._measured),
            jogged=list(self._jogged.values()),
        )

    async def do(self, run: StepRun) -> Found:
        """Fill what is held until all four are confirmed."""
        believed = await run.parts.planner.do(planning.believed, run.parameters)
        await run.take_rig()
        press: _Press | None = None
        self._last = self._now()
        while not all(one in self._jogged and self._jogged[one].filled for one in CHAMBERS):
            if self._now() - self._last > IDLE:
                raise CommandRefused(f"no button was held for {IDLE:g} s")
            press = await self._follow(press, run, believed)
            confirmed = sum(one.filled is not None for one in self._jogged.values())
            run.say(_doing(press), confirmed / len(CHAMBERS), waits=press is None)
            await asyncio.sleep(POLL_S)
        self._keep(press, run)
        return judged(list(self._jogged.values()), run.file.valves.chambers)

    async def _follow(self, press: _Press | None, run: StepRun, believed: Believed) -> _Press | None:
        """Let the torques follow the button. A chamber that is still full when it is pressed again was empty before."""
        self._measured = run.pressures(WINDOW)
        held = self.held()
        if held != (press.chamber if press else None):
            self._keep(press, run)
            if held is None:
                await run.torque((0.0, 0.0))
                self._pressure = 0.0
                return None
            self._pressure = first_pressure(held, run.body.pressure, run.parameters, believed)
            press = _Press(held, self._now())
            self._empty = self._measured if self._empty is None else np.fmin(self._empty, self._measured)
        if press is None:
            return None
        passed = self._now() - press.since
        if press.share < 1.0:
            press = press._replace(share=min(1.0, passed / FILL_S))
            await run.torque(jog_torque(press.chamber, press.share * self._pressure, run.parameters))
        elif self._empty is not None and passed > FILL_S + SETTLED:
            press = press._replace(shown=self._measured)
            self._note(press.chamber, self._measured - self._empty)
        return press

    def _keep(self, press: _Press | None, run: StepRun) -> None:
        """For the report, at a press's end."""
        if press is not None and press.shown is not None and self._empty is not None:
            run.keep_pair(f"{CHAMBERS[press.chamber]} filled, pressures", self._empty, press.shown, "Pa")

    def _note(self, chamber: int, rises: Array) -> None:
        name = CHAMBERS[chamber]
        risen = [one for one, rise in zip(CHAMBERS, rises, strict=True) if rise > RISE_SHARE * self._pressure]
        before = self._jogged.get(name)
        self._jogged[name] = Jogged(
            commanded=name,
            rises=numbers_of(rises),
            rose=risen[0] if len(risen) == 1 else None,
            filled=before.filled if before else None,
        )


def judged(jogged: Sequence[Jogged], channels: Sequence[int]) -> Found:
    """The order of channels by four confirmed chambers, each of which was commanded through its one of `channels`."""
    faults = []
    by_filled: dict[Chamber, list[Chamber]] = {}
    for one in jogged:
        if one.filled is not None:
            by_filled.setdefault(one.filled, []).append(one.commanded)
        if one.rose is None:
            faults.append(f"{one.commanded} was filled, and no sensor, or more than one, rose with it")
        elif one.rose != one.commanded:
            faults.append(f"{one.commanded} was filled, and the sensor of {one.rose} rose: their wires are crossed")
    faults += [f"{' and '.join(by)} both filled {filled}" for filled, by in by_filled.items() if len(by) > 1]
    if faults:
        return Found(False, "; ".join(faults) + ": jog again")
    order = [channels[CHAMBERS.index(by_filled[chamber][0])] for chamber in CHAMBERS]
    same = list(channels) == order
    rises = [Number(name=f"{one.commanded}, rise", value=_own(one), unit="Pa") for one in jogged]
    text = f"chambers u1+, u1-, u2+, u2- hang at channels {', '.join(map(str, order))}"
    text += "" if same else f", not at {', '.join(map(str, channels))}"
    return Found(True, text, tuple(rises), {} if same else {"valves.chambers": [*order]})


def _own(one: Jogged) -> float | None:
    return one.rises[CHAMBERS.index(one.commanded)]


def _doing(press: _Press | None) -> str:
    return "waits for a button to be held" if press is None else f"fills {CHAMBERS[press.chamber]}"
