"""What the jog step makes of buttons and pressures: which chamber fills, by which sensor, within which bounds."""

import math
from typing import Any

import numpy as np
import pytest

from controller.errors import CommandRefused
from controller.schema.parameters import RigParameters, SafetyLimits
from server.hardware.commissioning import jog, planning
from server.hardware.commissioning.messages import CHAMBERS, Chamber, Jogged, StartBody
from server.hardware.commissioning.planning import Believed
from server.operate.procedure.motion import Torques

RIG = RigParameters()
STIFF = Believed(np.zeros((10, 2)), (1e-7, 1e-7))
"""An arm that hardly moves."""


def jogged(commanded: Chamber, filled: Chamber, rose: Chamber | None = None, none: bool = False) -> Jogged:
    rises = [9e3 if one == commanded else 0.0 for one in CHAMBERS]
    return Jogged(commanded=commanded, rises=rises, rose=None if none else rose or commanded, filled=filled)


def test_the_order_of_channels_follows_from_which_chamber_filled() -> None:
    same = jog.judged([jogged(one, one) for one in CHAMBERS], (4, 5, 6, 7))
    assert same.good and same.changes == {}
    crossed = dict(zip(CHAMBERS, ("u2-", "u1-", "u1+", "u2+"), strict=True))
    found = jog.judged([jogged(one, other) for one, other in crossed.items()], (4, 5, 6, 7))  # type: ignore[arg-type]
    assert found.good and found.changes == {"valves.chambers": [6, 5, 7, 4]}
    assert jog.judged([jogged(one, one) for one in CHAMBERS], (6, 5, 7, 4)).changes == {}


def test_two_buttons_that_fill_one_chamber_and_crossed_sensors_are_faults() -> None:
    twice = jog.judged([jogged(one, "u1+" if one == "u2-" else one) for one in CHAMBERS], (0, 1, 2, 3))
    assert not twice.good and "u1+ and u2- both filled u1+" in twice.text
    sensor = jog.judged([jogged(one, one, "u1-" if one == "u1+" else None) for one in CHAMBERS], (0, 1, 2, 3))
    assert not sensor.good and "u1+ was filled, and the sensor of u1- rose" in sensor.text
    silent = jog.judged([jogged(one, one, none=one == "u2+") for one in CHAMBERS], (0, 1, 2, 3))
    assert not silent.good and "u2+ was filled, and no sensor" in silent.text


def test_a_jogged_chamber_keeps_every_bound() -> None:
    full = RIG.actuator.u_max * RIG.actuator.pressure_map[0]
    for chamber in range(4):
        assert jog.jog_pressure(chamber, None, RIG) == pytest.approx(min(40e3, 0.2 * full))
        assert jog.jog_pressure(chamber, 150e3, RIG) == pytest.approx(min(40e3, 0.2 * full))
        assert jog.jog_pressure(chamber, 5e3, RIG) == 5e3
        assert jog.first_pressure(chamber, None, RIG, STIFF) == 0.45 * SafetyLimits().pressure_off_max
        assert jog.first_pressure(chamber, None, RIG, planning.believed(RIG)) == pytest.approx(5.97e3, abs=10.0)
        assert jog.first_pressure(chamber, None, RIG, Believed(np.zeros((10, 2)), (1e-4, 1e-6))) == 4e3
        assert jog.first_pressure(chamber, 5e3, RIG, STIFF) == 5e3
        u = jog.jog_torque(chamber, 10e3, RIG)
        p = [max(0.0, side * u[pair] * RIG.actuator.pressure_map[pair]) for pair in (0, 1) for side in (1, -1)]
        assert p == pytest.approx([10e3 if one == chamber else 0.0 for one in range(4)])


def test_a_button_counts_until_it_is_released_or_no_longer_renewed() -> None:
    now = [0.0]
    jogging = jog.Jogging(lambda: now[0])
    jogging.hold("u2+")
    now[0] = 0.39
    assert jogging.held() == 2
    jogging.hold("u2+")
    now[0] = 0.78
    assert jogging.held() == 2
    now[0] = 0.8
    assert jogging.held() is None
    jogging.hold("u1-")
    jogging.hold(None)
    assert jogging.held() is None
    with pytest.raises(CommandRefused, match=r"u2\+ was not jogged yet: hold its button for 1\.5 s"):
        jogging.confirm("u2+", "u2+")


class Pressed:
    """Stands for the step's run: what the sensors show, and what was commanded."""

    parameters, body = RIG, StartBody()

    def __init__(self, offsets: np.ndarray) -> None:
        self.levels, self.offsets = np.zeros(4), offsets
        self.asked, self.pairs = list[Torques](), list[tuple[str, float]]()

    def pressures(self, window: float) -> np.ndarray:
        return self.levels + self.offsets

    async def torque(self, u: Torques) -> None:
        self.asked.append(u)

    def keep_pair(self, what: str, before: np.ndarray, after: np.ndarray, unit: str) -> None:
        self.pairs.append((what, float(after[0] - before[0])))


async def test_a_button_let_go_for_a_moment_does_not_take_the_full_chamber_for_an_empty_one() -> None:
    now = [0.0]
    jogging = jog.Jogging(lambda: now[0])
    run = Pressed(np.array([300.0, math.nan, -400.0, 0.0]))
    asked = jog.first_pressure(0, None, RIG, STIFF)

    async def follow(press: Any, seconds: float, renewed: bool = True) -> Any:
        for _ in range(round(seconds / 0.1)):
            now[0] += 0.1
            if renewed:
                jogging.hold("u1+")
            press = await jogging._follow(press, run, STIFF)  # type: ignore[arg-type]
        return press

    press = await follow(None, 0.1)
    run.levels[0] = asked
    press = await follow(press, 1.5)
    filling = np.array(run.asked)[:, 0]
    assert len(filling) == 6 and np.diff(filling) == pytest.approx(filling[-1] / 5), "slowly, lest the arm swings"
    assert [one.rose for one in jogging.view().jogged] == ["u1+"]
    assert await follow(press, 0.6, renewed=False) is None
    run.levels[0] = 0.9 * asked  # has hardly begun to empty
    press = await follow(None, 0.1)
    run.levels[0] = asked
    press = await follow(press, 1.5)
    assert await follow(press, 0.6, renewed=False) is None
    assert run.pairs == [("u1+ filled, pressures", pytest.approx(asked))] * 2
    [found] = jogging.view().jogged
    assert found.rose == "u1+" and found.rises[0] == pytest.approx(asked) and found.rises[1] is None
