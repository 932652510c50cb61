"""Steps of the commissioning that last longer than rows are kept in memory."""

import asyncio
import math
from collections.abc import Callable, Coroutine
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar, cast

import numpy as np
import pytest

from controller.errors import CommandRefused
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.parameters import RigParameters, Settings
from server.access.permit import own
from server.hardware.commissioning import closed_loop, pressure, sweep
from server.hardware.commissioning.messages import StartBody
from server.hardware.commissioning.planning import Circle
from server.hardware.commissioning.step_run import StepContext, StepRun
from server.hardware.first_mode.measurement import Measuring, Parts
from server.hardware.first_mode.messages import FirstModeBody
from server.rig.history import Gathered, History
from tests.server.plots.test_history import rows as numbered
from tests.server.virtual_time import VirtualLoop

T = TypeVar("T")
RIG, KEPT = RigParameters(), 7000
"""Rows: 7 s in place of a minute, longer than one hold lasts."""
MIDDLE = (0.2, 0.05)


class Rig:
    """Rows at 1 kHz in virtual time: `show(t, rows)` says what they show."""

    def __init__(self, show: Callable[[np.ndarray, np.ndarray], None] = lambda t, rows: None) -> None:
        self.history, self._show, self._ticks = History(KEPT, 100), show, 0
        self.paused, self.info, self.operator = False, None, SimpleNamespace(settings=Settings())

    @property
    def newest(self) -> Any:
        return self.history.newest

    def boot(self) -> int:
        return 1

    def require_info(self) -> Any:
        return SimpleNamespace(boot=1, parameters=RIG)

    async def run(self) -> None:
        while True:
            rows = np.zeros(10, record_dtype(Telemetry))
            rows["slot"] = rows["tick"] = self._ticks + np.arange(10)
            rows["t_ns"], rows["p_ref"] = rows["tick"] * 1_000_000, MIDDLE
            self._show(rows["tick"] * 1e-3, rows)
            self.history.add(rows)
            self._ticks += 10
            await asyncio.sleep(0.01)


class Free(StepRun):
    """Nothing is asked of a rig."""

    async def take_rig(self, **settings: Any) -> None:
        pass

    async def torque(self, u: tuple[float, float]) -> None:
        pass

    async def target(self, at: tuple[float, float]) -> None:
        pass

    async def give_back(self) -> None:
        pass


class Planner:
    """Has a circle of 0.1 m, around which the tip goes for half a minute."""

    async def do(self, work: Any, *arguments: Any) -> Any:
        return Circle(MIDDLE, 0.1)


def on(rig: Rig, step: Callable[[StepRun], Coroutine[Any, Any, T]]) -> T:
    """What comes of `step`."""
    context = SimpleNamespace(rig=rig, history=rig.history, operator=rig.operator, kept=None, note=None)
    parts = SimpleNamespace(procedures=SimpleNamespace(context=context), planner=Planner())
    file: Any = SimpleNamespace(motion_capture=SimpleNamespace(rods=(10,)))
    run = Free("statics", StartBody(repeats=6, share=0.7), own(), file, Path(), cast(StepContext, parts))
    loop = VirtualLoop()
    rows = loop.create_task(rig.run())
    try:
        loop.run_until_complete(asyncio.sleep(1.0))
        return loop.run_until_complete(step(run))
    finally:
        rows.cancel()
        loop.run_until_complete(asyncio.sleep(0.1))
        loop.close()


def test_steps_of_slow_chambers_are_kept_from_the_first_row_to_the_last() -> None:
    def rising(t: np.ndarray, rows: np.ndarray) -> None:
        rows["pressure_meas"], rows["pressure_cmd"] = 5e3 * t[:, None], 80e3

    levels = pressure.LEVELS * 6
    found = on(Rig(rising), lambda run: pressure._steps(2, 80e3, levels, run))
    assert len(found.starts) == len(levels) and len(found.slots) > 24 * 3.9e3 > KEPT
    assert (np.diff(found.slots) == 1).all() and found.slots[0] < found.starts[0] and (found.asked == 80e3).all()
    assert found.shown == pytest.approx(5.0 * found.slots)


@pytest.mark.keyed()
def test_a_large_circle_is_judged_by_all_counted_laps() -> None:
    lap = 2.0 * math.pi * 0.1 / closed_loop.SPEED

    def wrong_at_first(t: np.ndarray, rows: np.ndarray) -> None:
        rows["error"][:, 0] = np.where((t > 3.0 + 1.5 * lap) & (t < 4.0 + 1.5 * lap), 0.05, 1e-3)

    found = on(Rig(wrong_at_first), closed_loop.do)
    largest = next(one for one in found.numbers if one.name == "largest error")
    rmse = next(one for one in found.numbers if one.name == "tip RMSE")
    assert largest.value == 0.05, "that was in the second of six laps"
    assert rmse.value == pytest.approx(math.sqrt(0.05**2 / (5 * lap) + 1e-6), rel=0.02)


def test_a_slow_release_is_kept_from_its_lead_on() -> None:
    def swung(t: np.ndarray, rows: np.ndarray) -> None:
        rows["markers"][:, 9] = np.column_stack((t, t))
        rows["p_meas"][:, 0] = 1e-3 * t

    u = (20.0 * RIG.controller.rest_rate, 0.0)
    lead = lambda run: sweep._decay(u, np.zeros(2), (10,), run)  # noqa: E731
    _, release = on(Rig(swung), lead)
    assert release.slot - release.slots[0] > 19_000 > KEPT and (np.diff(release.slots) == 1).all()


def test_the_first_mode_of_a_fast_loop_is_measured_by_all_of_its_steps() -> None:
    history = History(KEPT, 100)
    rig = SimpleNamespace(require_info=lambda: None, boot=lambda: 1)
    context = SimpleNamespace(history=history, rig=rig, operator=None, kept=None, note=None)
    parts = cast(Parts, SimpleNamespace(procedures=SimpleNamespace(context=context)))
    measuring = Measuring(parts, FirstModeBody(), 0.01, own())
    for step in range(4):
        history.add(rows_from(5000 * step))
        rig.newest = history.newest
        measuring.begin_step()
    assert measuring.seen is not None
    slots = measuring.seen.rows()["slot"]
    assert len(slots) >= 3 * 5000 - 1 and (np.diff(slots) == 1).all()


def rows_from(first: int) -> np.ndarray:
    found = numbered(first, 5000)
    found["slot"] = found["tick"]
    return found


def test_rows_that_are_gone_before_they_are_taken_are_said_to_be_lost() -> None:
    history = History(KEPT, 100)
    history.add(rows_from(0))
    seen = Gathered(history, 1.0, ("slot", "error"))
    seen.take(2.0)
    seen.take(2.0)
    assert (seen.rows().dtype.names, len(seen.rows())) == (("slot", "error"), 1000)
    for first in (5000, 10_000):
        history.add(rows_from(first))
    with pytest.raises(CommandRefused, match="telemetry of this step was lost"):
        seen.take(14.0)
