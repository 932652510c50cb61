"""Raw valves from the steps of our own loop: found in the twin's chambers, and the loop that follows is stable."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest

from controller.assembly.plant_parts import chambers
from controller.errors import ParameterError
from controller.kernels.plant.valve import REFERENCE_PRESSURE, Chambers, fill_chambers, regulate, valve_flow
from controller.kernels.plant.valve import PressureLoop as Law
from controller.schema.hardware import PressureLoop, Valves
from controller.schema.parameters import RigParameters, TwinParameters
from controller.simulation.pneumatic_fit import ChamberSteps
from controller.simulation.valve_fit import (
    DELAY_MOST,
    EXHAUST_AT,
    ValveFit,
    asked_openings,
    fit_valve,
    margins,
    tuned_loop,
    worst_margins,
)
from tests.controller.chains import compiled

pytestmark = pytest.mark.keyed()

DT, OLD, EVERY = 1e-3, 2, 2
"""Readings come every other tick, two ticks old, and so do the valves' commands go."""
WIRE = 2.5e-3
"""What that adds to the delay [s]."""
NOISE, BIT = 300.0, 250.0
"""Of a sensor [Pa]: 500 kPa in ten bits, and noise as large."""
FULL = 240e3
FIRST = Valves(driver="serial", command="opening")
"""With the gains that a rig file has by default."""


@compiled
def walk(plant: Chambers, law: Law, asked: np.ndarray, noise: np.ndarray, bit: float, shown: np.ndarray) -> None:
    """Loop, wire and chamber for each row of `asked` (n,4) [Pa]; `shown` (n,4) is what the loop had."""
    integral, command, read = np.zeros(4), np.zeros(4), np.zeros((8, 4))
    for i in range(asked.shape[0]):
        for j in range(4):
            shown[i, j] = shown[i - 1, j] if i > 0 else 0.0
            if i % EVERY == 0:
                shown[i, j] = np.rint((read[(i - OLD) % 8, j] + noise[i, j]) / bit) * bit
            opening, integral[j] = regulate(law, asked[i, j] - shown[i, j], integral[j], DT)
            if i % EVERY == 0:
                command[j] = opening
        fill_chambers(i, command, DT, plant)
        read[i % 8] = plant.pressure


def course(levels: tuple[float, ...], hold: float) -> tuple[np.ndarray, tuple[int, ...]]:
    """Setpoints (n,) [Pa] that go to each level at 2 MPa/s, as a torque does, and where each step begins."""
    rows = round(hold / DT)
    wanted = np.repeat([0.0, *levels], [200, *[rows] * len(levels)])
    ramped, at = np.empty_like(wanted), 0.0
    for row, level in enumerate(wanted):
        at += float(np.clip(level - at, -2e3, 2e3))
        ramped[row] = at
    return ramped, tuple(range(200, len(wanted), rows))


@dataclass
class Raw:
    """Four alike chambers behind raw valves, and a loop around them."""

    twin: TwinParameters
    noise: float = NOISE

    @property
    def truth(self) -> ValveFit:
        """Its numbers, by the valve's own equations."""
        plant = chambers(RigParameters(twin=self.twin), self.twin.torque_gain).valve
        fill, exhaust = (
            REFERENCE_PRESSURE / plant.volume * abs(valve_flow(plant, way, p))
            for way, p in ((1.0, 0.0), (-1.0, EXHAUST_AT))
        )
        return ValveFit(self.twin.dead_time + WIRE, self.twin.valve_lag, self.twin.valve_offset, fill, exhaust, 0.0)

    def step(self, loop: PressureLoop, asked: np.ndarray, seed: int = 0) -> np.ndarray:
        """What the sensors show (n,4) [Pa]."""
        plant = chambers(RigParameters(twin=self.twin), self.twin.torque_gain)
        plant.raw[0], plant.spool[:] = 1, -1.0
        columns = np.ascontiguousarray(np.tile(asked[:, None], (1, 4)))
        shown, noise = np.zeros_like(columns), np.random.default_rng(seed).normal(0.0, self.noise, columns.shape)
        law = Law(loop.inflate_gain, loop.exhaust_gain, loop.integral_time)
        walk(plant, law, columns, noise, BIT if self.noise else 1e-3, shown)
        return shown

    def found(self, valves: Valves = FIRST, level: float = 27e3) -> list[ValveFit]:
        """By one small step up and down of each chamber."""
        asked, starts = course((level, 0.0), 0.8)
        shown = self.step(valves.loop, asked)
        return [fit_valve(ChamberSteps(asked, shown[:, j], starts), valves, DT) for j in range(4)]


def overshoot(shown: np.ndarray, levels: tuple[float, ...], starts: tuple[int, ...], slow: float) -> tuple[float, bool]:
    """Furthest beyond any level [Pa], and whether each was settled (2.5 kPa, or a twentieth) within 8 `slow` [s]."""
    worst, settled, before = 0.0, True, 0.0
    for level, start, end in zip(levels, starts, [*starts[1:], len(shown)], strict=True):
        part, way = shown[start:end], level - before
        if level > 0.0:  # an empty chamber has nothing to overshoot into, and its end is slow by nature
            worst = max(worst, float((np.sign(way) * (part - level)).max()))
            settled &= bool((np.abs(part[round(8 * slow / DT) :] - level) < max(2.5e3, abs(way) / 20)).all())
        before = level
    return worst, settled


def valves_of(dead_time: float, lag: float, conductance: float, supply: float, **more: float) -> Raw:
    twin = {"dead_time": dead_time, "valve_lag": lag, "conductance": conductance, "supply_pressure": supply}
    return Raw(TwinParameters(**twin | more))  # type: ignore[arg-type]


def valves_in_range(*choices: tuple[float, ...]) -> list[Raw]:
    """All of these dead times, spools, sizes and supplies that docs/commissioning.md says can be had."""
    every = [valves_of(*each) for each in itertools.product(*choices)]
    return [one for one in every if one.truth.theta < 0.96 * DELAY_MOST and one.truth.fill * one.truth.theta < 500e3]


SOME = ((0.0, 0.03, 0.09), (1.3e-3, 0.03), (1.3e-9, 1.2e-8), (300e3, 600e3))
MANY = ((0.0, 0.01, 0.03, 0.06, 0.09), (1.3e-3, 0.01, 0.03), (1.3e-9, 3.9e-9, 1.2e-8), (300e3, 600e3))


@pytest.mark.parametrize("choices", [SOME, pytest.param(MANY, marks=pytest.mark.long)], ids=["some", "many"])
def test_over_the_whole_range_of_valves_the_proposed_loop_is_stable_settles_and_hardly_overshoots(
    choices: tuple[tuple[float, ...], ...],
) -> None:
    seen = []
    for raw in valves_in_range(*choices):
        full, true, found = min(FULL, 0.8 * raw.twin.supply_pressure), raw.truth, raw.found()
        loop = tuned_loop(found, full)
        least, slow = worst_margins(loop, [true], full), loop.integral_time / 4.0
        beyond = []
        for levels in ((80e3, 27e3, 53e3, 0.0), (full, full - 40e3, full, full / 2, full)):
            asked, starts = course(levels, 10 * slow)
            most, settled = overshoot(raw.step(loop, asked, seed=1)[:, 0], levels, starts, slow)
            assert settled, (raw, levels)
            beyond.append(most)
        off = max(max(abs(one.fill / true.fill - 1.0), abs(one.exhaust / true.exhaust - 1.0)) for one in found)
        late = max(abs(one.theta - true.theta) for one in found)
        seen.append((off, late, math.degrees(least.phase), least.delay / true.theta, max(beyond)))
    rates, late, phase, delay, beyond = np.array(seen).T
    print(f"{len(seen)} valves: rates within {rates.max():.1%}, delay within {late.max() * 1e3:.1f} ms, ", end="")
    print(f"phase margin {phase.min():.0f} deg, delay margin {delay.min():.2f} delays, overshoot {beyond.max():.0f} Pa")
    assert rates.max() < 0.08 and late.max() < 0.015
    assert phase.min() > 45.0 and delay.min() > 1.2 and beyond.max() < 6e3


def test_a_loop_that_swings_tells_its_valve_as_well_as_one_that_creeps() -> None:
    raw = valves_of(0.03, 1.3e-3, 3.9e-9, 600e3)
    for gain in (5e-7, 1.2e-5):  # of 8.5e-6 on it swings for good
        loop = PressureLoop(inflate_gain=gain, exhaust_gain=2 * gain, integral_time=0.3)
        found = raw.found(Valves(driver="serial", command="opening", loop=loop))[0]
        assert found.fill == pytest.approx(raw.truth.fill, rel=0.1)
        assert found.exhaust == pytest.approx(raw.truth.exhaust, rel=0.1)
        assert found.theta == pytest.approx(raw.truth.theta, abs=5e-3)


def test_the_margins_are_those_that_simc_is_known_for() -> None:
    valve = ValveFit(0.02, 0.0, 0.0, 4e6, 1e6, 0.0)
    gain = 1.0 / (4e6 * 2 * 0.02)
    tight = margins(gain, gain / (8 * 0.02), 4e6, valve)  # Skogestad 2003, table 1: 46.9 deg, 1.59 delays
    assert math.degrees(tight.phase) == pytest.approx(46.9, abs=0.1)
    assert tight.delay / 0.02 == pytest.approx(1.59, abs=0.01)
    swings = margins(0.5 * math.pi / (4e6 * 0.02), 0.0, 4e6, valve)
    assert swings.phase == pytest.approx(0.0, abs=1e-3)  # an integrator with dead time, at its limit
    spool = valve._replace(delay=0.0, spool=0.02)
    assert margins(1e-3, 0.0, 4e6, spool).phase > 0.0  # second order: never


def test_the_gains_are_those_of_the_fastest_chamber_and_the_latest_valve() -> None:
    slow = ValveFit(0.01, 0.002, 0.0, 2e6, 0.5e6, 0.0)
    late = slow._replace(delay=0.03)
    fast = slow._replace(fill=4e6)
    loop = tuned_loop([slow, late, fast], FULL)
    assert loop.inflate_gain == pytest.approx(1.0 / (4e6 * 3 * 0.032), rel=0.01)
    assert loop.integral_time == pytest.approx(4 * 3 * 0.032, rel=0.01)
    assert loop.exhaust_gain < 1.0 / (0.5e6 * 3 * 0.032)  # a full chamber is emptied faster
    assert tuned_loop([slow], 60e3).exhaust_gain == pytest.approx(1.0 / (0.5e6 * 0.042), rel=0.01)
    weak = tuned_loop([slow._replace(fill=1e3, exhaust=1e3)], FULL)
    assert weak.inflate_gain == 1e-2
    with pytest.raises(ParameterError, match=r"the valves answer after 112 ms .* at most 100 ms: use valves that hold"):
        tuned_loop([slow, late._replace(delay=0.11)], FULL)


def test_openings_are_those_that_the_tick_would_have_asked_for() -> None:
    asked, starts = course((27e3, 0.0), 0.3)
    shown = valves_of(0.0, 1.3e-3, 3.9e-9, 600e3).step(FIRST.loop, asked)[:, 0]
    shown[40:50] = np.nan
    found = asked_openings(ChamberSteps(asked, shown, starts), FIRST, DT)  # but for the integral: 0.012 at most
    law = Law(FIRST.loop.inflate_gain, FIRST.loop.exhaust_gain, FIRST.loop.integral_time)
    assert found[300] == pytest.approx(
        regulate(law, asked[300] - shown[300], 0.0, DT)[0], abs=0.012
    )  # the integral's most
    assert np.isfinite(found).all() and np.abs(found).max() <= 1.0
    held = asked_openings(ChamberSteps(asked, shown, starts), FIRST.model_copy(update={"slew_max": 1e3}), DT)
    assert held.max() < 0.1 * found.max()  # no setpoint leaves faster than it may


@pytest.mark.parametrize(
    "change, complaint",
    [
        (lambda shown: np.zeros_like(shown), "its pressure moved by 0 Pa: too little to tell its valve"),
        (lambda shown: np.full_like(shown, np.nan), "its pressure was not measured"),
        (lambda shown: 27e3 - shown, "it does not follow its valve"),
    ],
)
def test_a_chamber_that_does_not_follow_its_valve_is_refused(change: object, complaint: str) -> None:
    asked, starts = course((27e3, 0.0), 0.8)
    shown = valves_of(0.0, 1.3e-3, 3.9e-9, 600e3).step(FIRST.loop, asked)[:, 0]
    with pytest.raises(ParameterError, match=complaint):
        fit_valve(ChamberSteps(asked, change(shown), starts), FIRST, DT)  # type: ignore[operator]
