"""Docs and kernel are made from one table; each watchdog keeps still just within its bound and acts just beyond it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from controller.kernels.safety import safety
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import SafetyLimits
from controller.schema.safety_tables import PAGE, filled
from controller.schema.states import KEPT, TRANSITIONS, WATCHDOGS, Watch, Watchdog, next_mode
from tests.controller.desk import MS, Desk
from tests.controller.kernels.safety.test_safety import ALLOWED

LIMITS = SafetyLimits()
ROOT = Path(__file__).parents[4]


def test_the_page_holds_the_tables_of_the_loop() -> None:
    page = (ROOT / PAGE).read_text()
    assert filled(page) == page, "docs/safety.md is stale: make schema"
    assert filled(page.replace("| HOLD |", "| TRACK |")) == page


def test_the_kernel_acts_by_the_table_and_the_table_is_the_design() -> None:
    assert TRANSITIONS == ALLOWED
    for mode in Mode:
        for request in Request:
            wanted = next_mode(mode, request)
            assert safety.TRANSITIONS[mode, request] == (safety.REFUSED if wanted is None else wanted)


def test_every_bound_is_a_limit_and_every_limit_bounds_something() -> None:
    named = {name for dog in WATCHDOGS.values() for name in dog.limits}
    assert named | {"measurement_old"} == set(SafetyLimits.model_fields)
    assert list(WATCHDOGS) == list(Watch)


def absent(name: str, limit: str) -> Callable[[Desk, float], None]:
    """The sender called `name` on the desk falls silent for `share` of a limit."""

    def act(desk: Desk, share: float) -> None:
        setattr(desk, name, False)
        desk.step(round(1000 * share * float(desk.rig.control.limits[limit][0])))

    return act


def stall(desk: Desk, share: float) -> None:
    desk.step(gap=round(1000 * LIMITS.loop_gap * share))


def age_markers(desk: Desk, share: float) -> None:
    """From a sample that is 1 ms old already."""
    desk.camera = False
    desk.step(round(1000 * LIMITS.measurement_lost * share) - 1)


def jump(desk: Desk, share: float) -> None:
    desk.markers[:, 1] += 0.1
    desk.step(round(1000 * LIMITS.measurement_lost * share) - 1)


def freeze(desk: Desk, share: float) -> None:
    """A sample like one of long ago, since which the model has been given another torque."""
    state, desk.still = desk.rig.control.state, True
    desk.step()
    state["moved_ns"] = desk.now - round(1e9 * LIMITS.frozen_time) - 10 * MS
    state["u_moved"][0] = desk.rig.observer.u_hat + np.array([0.0, LIMITS.frozen_torque * share])
    desk.step()


def miss(desk: Desk, share: float) -> None:
    """As if it had been off for so long."""
    desk.rig.control.state["off_time"] = LIMITS.error_time * share
    desk.step()


def spread(desk: Desk, share: float) -> None:
    """As if the error had been so far from its mean."""
    state = desk.rig.control.state
    mean = state["error_mean"][0] = (0.03, -0.02)
    state["error_square"] = (LIMITS.error_rms_max * share) ** 2 + np.dot(mean, mean)
    desk.step()


def swing(desk: Desk, share: float) -> None:
    """As if the error had swung for so long."""
    desk.rig.control.state["swing_off"] = LIMITS.swing_time * share
    desk.step()


def sway(desk: Desk, share: float) -> None:
    """As if the error swung like this from now on, beside a reference that swings by 10 mm."""
    state = desk.rig.control.state
    for _ in range(round(1100 * LIMITS.swing_time)):
        state["swing_held"], state["swing_ref"] = 0.01**2, 0.0
        state["error_slow"], state["ref_slow"] = desk.telemetry["error"], desk.telemetry["p_ref"]
        state["swing"] = share**2 * (LIMITS.swing_max**2 + (LIMITS.swing_ratio * 0.01) ** 2)
        desk.step()


def drift(desk: Desk, share: float) -> None:
    """As if the observer had been off for so long."""
    desk.rig.control.state["residual_off"] = LIMITS.residual_time * share
    desk.step()


def rush(desk: Desk, share: float) -> None:
    """Before the watchdog looks, the observer takes a step: far beyond and far within."""
    desk.rig.control.v[1] += LIMITS.speed_max * (1.0 + 20.0 * (share - 1.0))
    desk.step()


def leak(desk: Desk, share: float) -> None:
    desk.leak[0] = LIMITS.pressure_off_max * share
    desk.step(round(1100 * LIMITS.pressure_off_time))


def linger(desk: Desk, share: float) -> None:
    desk.leak[0] = 2 * LIMITS.pressure_off_max
    desk.step(round(1000 * LIMITS.pressure_off_time * share))


def lose_number(desk: Desk, share: float) -> None:
    desk.command["target"] = (0.1, 0.1 if share < 1.0 else np.nan)
    desk.step()


def overfill(desk: Desk, share: float) -> None:
    desk.measurement["pressures"] = (0.0, LIMITS.pressure_max * share, 0.0, LIMITS.pressure_max * share)
    desk.step()


def underfill(desk: Desk, share: float) -> None:
    desk.measurement["pressures"] = (0.0, 0.0, LIMITS.pressure_min * share, 0.0)
    desk.step()


def silence_board(desk: Desk, share: float) -> None:
    """As if it were hardware, whose board was heard until now."""
    desk.measurement["pressures_ns"] = desk.now
    desk.step(round(1000 * LIMITS.pressures_lost * share))


class Trial(NamedTuple):
    watch: Watch
    act: Callable[[Desk, float], None]


TRIALS = [
    Trial(Watch.LOOP, stall),
    Trial(Watch.OPERATOR, absent("operator", "operator_timeout")),
    Trial(Watch.SERVER_SILENT, absent("server", "server_hold")),
    Trial(Watch.SERVER_GONE, absent("server", "server_rest")),
    Trial(Watch.PUMP_SILENT, absent("pump", "pump_hold")),
    Trial(Watch.PUMP_GONE, absent("pump", "pump_rest")),
    Trial(Watch.MARKERS_LOST, age_markers),
    Trial(Watch.MARKERS_JUMPED, jump),
    Trial(Watch.MARKERS_FROZEN, freeze),
    Trial(Watch.ERROR, miss),
    Trial(Watch.ERROR_RMS, spread),
    Trial(Watch.OSCILLATION, swing),
    Trial(Watch.OSCILLATION, sway),
    Trial(Watch.RESIDUAL, drift),
    Trial(Watch.SPEED, rush),
    Trial(Watch.FLOW, leak),
    Trial(Watch.FLOW, linger),
    Trial(Watch.NUMBERS, lose_number),
    Trial(Watch.PRESSURE, overfill),
    Trial(Watch.PRESSURE, underfill),
    Trial(Watch.PRESSURES_LOST, silence_board),
]
WITHIN, BEYOND = 0.97, 1.03
LATER = (Watch.SERVER_GONE, Watch.PUMP_GONE)
"""Another has acted before them, for the same cause."""


def tried(trial: Trial, mode: Mode, share: float) -> Desk:
    desk = Desk()
    desk.into(mode)
    desk.step(10)
    desk.rig.control.limits["server_rest"] = desk.rig.control.limits["pump_rest"] = 1.0
    trial.act(desk, share)
    return desk


def test_every_watchdog_is_tried() -> None:
    assert {trial.watch for trial in TRIALS} == set(Watch)


def came_to_rest(dog: Watchdog, mode: Mode) -> tuple[Mode, Cause] | None:
    """Where a REST that begins without torque ends at once."""
    cause = dog.cause if dog.cause in KEPT else Cause.RESTED
    return (Mode.VENTED, cause) if dog.reaction == Mode.REST != mode else None


@pytest.mark.parametrize("mode", Mode, ids=lambda mode: mode.name)
@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: f"{trial.watch.name}-{trial.act.__name__}")
def test_a_watchdog_acts_beyond_its_bound_in_its_modes_and_nowhere_else(trial: Trial, mode: Mode) -> None:
    dog = WATCHDOGS[trial.watch]
    within, beyond = tried(trial, mode, WITHIN), tried(trial, mode, BEYOND)
    assert within.cause != dog.cause or (trial.watch in LATER and within.mode == Mode.HOLD)
    acted = (beyond.mode, beyond.cause) in ((dog.reaction, dog.cause), came_to_rest(dog, mode))
    assert acted == (mode in dog.modes), (beyond.mode, beyond.cause)
