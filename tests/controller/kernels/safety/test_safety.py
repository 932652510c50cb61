"""The safety states: every cell of the transition table, every watchdog, and what it takes to move again."""

import numpy as np
import pytest

from controller.kernels.control.task_space_pi import U_INT
from controller.schema.modes import Cause, Law, Mode, Request, RowKind
from tests.controller.desk import Desk
from tests.controller.trial import SOFT, Trial, twin_with

V, H, F, T, R, X, E = Mode
REFUSED = None
ALLOWED = {
    V: {Request.ARM: H},
    H: {Request.HOLD: H, Request.FOLLOW: F, Request.TRACK: T, Request.REST: R},
    F: {Request.HOLD: H, Request.FOLLOW: F, Request.REST: R},
    T: {Request.HOLD: H, Request.FOLLOW: F, Request.REST: R},
    R: {Request.HOLD: H, Request.REST: R},
    X: {Request.CLEAR: V},
    E: {Request.CLEAR: V},
}
"""The transitions of docs/safety.md, written again. NONE is always taken and E_STOP always stops."""
LIVE, MOVING = (H, F, T), (F, T)


@pytest.mark.parametrize("mode", Mode, ids=lambda mode: mode.name)
@pytest.mark.parametrize("request_", Request, ids=lambda request: request.name)
def test_every_request_in_every_mode_is_taken_or_refused_as_designed(mode: Mode, request_: Request) -> None:
    desk = Desk()
    desk.into(mode)
    expected = {Request.NONE: mode, Request.E_STOP: E, **ALLOWED[mode]}.get(request_, REFUSED)
    desk.rig.control.state["u"] = 0.01
    row = desk.ask(request_)
    assert row["request_n"] == desk.command["request_n"][0]
    assert desk.mode == (mode if expected is REFUSED else expected)
    assert row["request_cause"] == (Cause.WRONG_MODE if expected is REFUSED else Cause.NONE)
    if expected is REFUSED:
        before = desk.mode
        desk.step(3)
        assert desk.mode == before


def test_a_request_acts_once_and_not_again_when_repeated() -> None:
    desk = Desk()
    desk.into(F)
    desk.rig.control.state["mode"] = H
    desk.step(5)
    assert desk.mode == H


def test_a_request_for_another_life_of_the_rig_is_refused_but_a_stop_is_not() -> None:
    desk = Desk()
    desk.step(20)
    row = desk.ask(Request.ARM, boot=6)
    assert (desk.mode, row["request_cause"]) == (V, Cause.WRONG_BOOT)
    desk.ask(Request.E_STOP, boot=6)
    assert desk.mode == E


def test_moving_needs_an_operator_and_tracking_a_reference() -> None:
    desk = Desk()
    desk.into(H)
    desk.operator = False
    desk.step(600)
    assert desk.ask(Request.FOLLOW)["request_cause"] == Cause.NO_OPERATOR
    desk.operator = True
    desk.plan(np.zeros((0, 2)))
    assert desk.ask(Request.TRACK)["request_cause"] == Cause.NO_REFERENCE
    assert desk.mode == H


@pytest.mark.parametrize("mode", MOVING)
def test_without_its_operator_the_rig_holds_and_needs_a_fresh_request(mode: Mode) -> None:
    desk = Desk()
    desk.into(mode)
    desk.operator = False
    desk.step(499)
    assert desk.mode == mode
    desk.step(5)
    assert (desk.mode, desk.cause) == (H, Cause.OPERATOR_LOST)
    desk.operator = True
    desk.step(100)
    assert desk.mode == H
    desk.ask(Request.FOLLOW)
    assert desk.mode == F


def test_two_servers_that_repeat_their_commands_are_no_operator() -> None:
    """Each repeats its own last presence, so the number changes all the time; no one is there."""
    desk = Desk()
    desk.into(F)
    desk.operator = False
    mine = int(desk.command["presence"][0])
    for _ in range(12):
        for presence in (mine - 40, mine):
            desk.command["presence"] = presence
            desk.step(50)
    assert (desk.mode, desk.cause) == (H, Cause.OPERATOR_LOST)


def test_an_unattended_run_finishes_without_an_operator() -> None:
    desk = Desk()
    desk.into(H)
    desk.plan(np.tile([0.25, 0.01], (1500, 1)))
    desk.ask(Request.TRACK, unattended=1)
    desk.operator = False
    desk.step(1400)
    assert desk.mode == T
    desk.step(110)
    assert (desk.mode, desk.cause) == (H, Cause.REFERENCE_DONE)


def test_a_reference_that_repeats_never_stops_between_its_laps_and_ends_where_it_is_to() -> None:
    desk, rows = Desk(), np.column_stack([np.full(300, 0.25), np.linspace(0.0, 0.03, 300)])
    desk.into(H)
    desk.plan(rows, again=100, ticks=650)
    desk.ask(Request.TRACK)
    followed = [desk.telemetry["p_ref"][0].copy()] + [desk.step()["p_ref"].copy() for _ in range(649)]
    wanted = np.vstack([rows, rows[100:], rows[100:250]])
    assert desk.mode == T
    assert np.array_equal(desk.rig.control.state["wish"][0], wanted[-1])
    assert np.linalg.norm(np.array(followed)[400:500] - wanted[400:500], axis=1).max() < 1e-3
    desk.step()
    assert (desk.mode, desk.cause) == (H, Cause.REFERENCE_DONE)


def test_the_law_of_a_run_ends_with_it() -> None:
    """In HOLD after it the feedback is that of any other HOLD, from its first tick on."""
    desk, rows = Desk(), np.column_stack([np.full(300, 0.25), np.linspace(0.0, 0.03, 300)])
    desk.into(H)
    desk.plan(rows)
    desk.rig.control.kinds[: len(rows)] = RowKind.KNOWN
    desk.rig.control.guide[: len(rows)] = 0.0
    state = desk.rig.control.state[0]
    desk.ask(Request.TRACK)
    desk.step(299)
    assert (desk.mode, state["kind"], state["guided"]) == (T, RowKind.KNOWN, 1)
    desk.step()
    assert (desk.mode, desk.cause) == (H, Cause.REFERENCE_DONE)
    assert (state["kind"], state["guided"]) == (RowKind.DRAWN, 0)
    desk.ask(Request.TRACK)
    desk.step(10)
    assert (desk.mode, state["kind"]) == (T, RowKind.KNOWN)
    desk.ask(Request.HOLD)
    assert (desk.mode, state["kind"], state["guided"]) == (H, RowKind.DRAWN, 0)


@pytest.mark.parametrize("mode", LIVE)
def test_without_the_server_the_rig_holds_and_later_rests(mode: Mode) -> None:
    desk = Desk()
    desk.into(mode)
    desk.server = False
    desk.step(505)
    assert desk.mode == H
    assert desk.cause == (Cause.SERVER_LOST if mode in MOVING else Cause.OPERATOR)
    desk.step(29_480, gap=40)
    assert desk.mode == H
    desk.step(40)
    assert desk.cause in (Cause.SERVER_LOST, Cause.RESTED)
    assert desk.mode in (R, V)


def test_without_the_pump_the_rig_holds_and_then_rests() -> None:
    desk = Desk()
    desk.into(F)
    desk.pump = False
    desk.step(505)
    assert (desk.mode, desk.cause) == (H, Cause.PUMP_LOST)
    desk.step(1500)
    assert desk.mode in (R, V)


def test_without_markers_feedback_goes_off_and_then_the_rig_faults_and_rests() -> None:
    desk = Desk()
    desk.into(F)
    desk.command["target"] = (0.2, 0.08)
    desk.step(200)
    desk.camera = False
    desk.step(60)
    held = desk.rig.control.slot.memory[U_INT : U_INT + 2].copy()
    row = desk.step(100)
    assert (desk.mode, row["sensed"]) == (F, 0)
    assert np.abs(held).max() > 0.0 and desk.rig.control.slot.memory[U_INT : U_INT + 2] == pytest.approx(held)
    assert np.isnan(row["p_meas"]).all()
    desk.step(400)
    assert (desk.mode, desk.cause) == (X, Cause.MEASUREMENT_LOST)
    row = desk.step(3000)
    assert (desk.mode, desk.cause) == (X, Cause.MEASUREMENT_LOST)
    assert not row["u"].any()


def test_a_hidden_marker_counts_as_no_measurement_while_another_one_serves() -> None:
    desk = Desk(sensed=(1 << 9) | (1 << 5))
    desk.into(H)
    desk.markers[9] = np.nan
    row = desk.step(1000)
    assert (desk.mode, row["sensed"]) == (H, 1 << 5)
    assert np.isfinite(row["error"]).all()
    desk.markers[5] = np.nan
    desk.step(600)
    assert (desk.mode, desk.cause) == (X, Cause.MEASUREMENT_LOST)


def test_after_a_stall_of_the_loop_the_rig_holds_and_nothing_else_is_blamed() -> None:
    desk = Desk()
    desk.into(F)
    desk.server = desk.pump = desk.camera = desk.operator = False
    desk.step(gap=5000)
    assert (desk.mode, desk.cause) == (H, Cause.LOOP_STALLED)
    desk.server = desk.pump = desk.camera = True
    desk.step(1000)
    assert (desk.mode, desk.cause) == (H, Cause.LOOP_STALLED)


def test_stalls_of_the_loop_do_not_hide_that_the_server_is_gone() -> None:
    desk = Desk()
    desk.into(H)
    desk.server = False
    for _ in range(58):
        desk.step(440)
        desk.step(gap=60)
    assert desk.mode == H
    desk.step(1200)
    assert desk.mode in (R, V)


def test_a_persistent_tracking_error_in_reach_is_a_fault() -> None:
    desk = Desk()
    desk.into(F)
    desk.command["target"] = (0.1, 0.14)
    desk.step(3500)
    assert (desk.mode, desk.cause) == (X, Cause.TRACKING_ERROR)


def test_a_loop_that_swings_about_its_target_comes_to_rest_and_says_so() -> None:
    """Gains within their bounds can make the tip whip through its reference: it is near it five times a second."""
    trial = Trial(parameters=twin_with(**SOFT), K_P=(3.0, 3.0), K_I=(20.0, 20.0))
    trial.arm()
    rows = trial.follow(0.1, 0.12, 12.0)
    rest = int(np.argmax(rows["mode"] == R))
    assert rest and rows["cause"][rest] == Cause.OSCILLATION
    assert np.hypot(*rows["error"][:rest].T).max() < 0.15
    assert (rows["mode"][-1], rows["cause"][-1]) == (V, Cause.OSCILLATION), "the reason stays in sight"


def test_a_slow_wide_swing_comes_to_rest_by_its_rms() -> None:
    """A wide swing below the band of the other watchdog, as a heavy arm makes it; near its reference twice a period."""
    desk = Desk()
    desk.command["target"] = (0.25, 0.0)
    desk.into(F)
    for other in ("swing_max", "error_max", "residual_max"):
        desk.rig.control.limits[other] = 1.0
    for t in range(4000):
        if desk.mode != F:
            break
        desk.markers[9] = (0.25, 0.25 * np.sin(2 * np.pi * 0.5e-3 * t))
        desk.step()
    assert (desk.mode, desk.cause) == (R, Cause.TRACKING_RMS)


def test_an_observer_that_stays_far_from_its_markers_is_a_fault() -> None:
    """Markers that creep away, each step too small for a jump, from a model that does not follow them."""
    desk = Desk(K_o=(0.0, 0.0), B_o=(0.0, 0.0), law=Law.FF)
    desk.into(H)
    for _ in range(3000):
        if desk.mode != H:
            break
        desk.markers[:, 1] += 5e-5
        desk.step()
    assert (desk.mode, desk.cause) == (X, Cause.RESIDUAL)
    assert 0.089 < desk.markers[9, 1] < 0.095, "a second at 50 mm/s after 40 mm"


def test_a_marker_is_used_again_where_its_own_motion_led_it_while_it_was_out_of_sight() -> None:
    """The model, which nothing pulls at meanwhile, stays where it was."""
    desk = Desk(K_o=(0.0, 0.0), B_o=(0.0, 0.0), law=Law.FF)
    desk.into(H)
    for _ in range(20):
        desk.markers[9, 1] += 1.5e-3
        assert desk.step()["sensed"] == 1 << 9
    y, desk.markers[9, 1] = desk.markers[9, 1], np.nan
    desk.step(40)
    desk.markers[9, 1] = y + 41 * 1.5e-3
    assert desk.step()["sensed"] == 1 << 9


def test_a_marker_that_jumped_is_not_used_for_being_out_of_sight_for_a_moment() -> None:
    desk = Desk(law=Law.FF)
    desk.into(H)
    x, y = desk.markers[9] + (0.0, 0.04)
    for _ in range(23):
        desk.markers[9] = x, y
        assert desk.step()["sensed"] == 0
        desk.markers[9] = np.nan
        desk.step(20)
    desk.step(40)
    assert (desk.mode, desk.cause) == (X, Cause.MEASUREMENT_JUMPED)


@pytest.mark.parametrize("mode", [V, H, F, R, X])
@pytest.mark.parametrize("where", ["command", "settings", "pose", "pressure"])
def test_a_number_that_is_not_finite_or_too_high_vents_at_once(mode: Mode, where: str) -> None:
    desk = Desk()
    desk.into(mode)
    if where == "command":
        desk.command["target"] = (np.nan, 0.1)
    elif where == "settings":
        desk.command["settings"]["K_P"] = (np.inf, 0.1)
    elif where == "pose":
        desk.rig.control.q[2, 3] = np.nan
    else:
        desk.measurement["pressures"] = (0.0, 350e3, 0.0, 0.0)
    row = desk.step()
    assert (desk.mode, desk.cause) == (E, Cause.PRESSURE if where == "pressure" else Cause.NOT_FINITE)
    assert not row["u"].any()
    assert not row["pressure_cmd"].any()


def test_after_a_stop_for_a_lost_number_the_rig_can_be_cleared_and_armed() -> None:
    desk = Desk()
    desk.into(F)
    desk.rig.control.q[2, 0] = np.nan
    desk.step(10)
    assert desk.ask(Request.ARM)["request_cause"] == Cause.WRONG_MODE
    desk.ask(Request.CLEAR)
    row = desk.step()
    assert desk.mode == V
    assert np.isfinite(row["p_hat"]).all()
    desk.ask(Request.ARM)
    row = desk.step(100)
    assert desk.mode == H
    assert np.isfinite(row["u"]).all()


def test_a_stop_vents_within_its_tick_and_latches() -> None:
    desk = Desk()
    desk.into(F)
    desk.command["target"] = (0.1, 0.14)
    assert desk.step(800)["pressure_cmd"].max() > 10e3
    row = desk.ask(Request.E_STOP)
    assert (desk.mode, desk.cause) == (E, Cause.OPERATOR)
    assert not row["u"].any()
    assert not row["pressure_cmd"].any()
    desk.step(1000)
    assert desk.mode == E


def test_rest_brings_the_torque_down_at_its_rate_and_then_vents() -> None:
    desk = Desk()
    desk.into(F)
    desk.command["target"] = (0.1, 0.14)
    before = desk.step(800)["u"].copy()
    desk.ask(Request.REST)
    row, peak = desk.step(), np.abs(before).max()
    assert np.abs(row["u"] - before).max() <= 2 * 0.03e-3 + 1e-12
    desk.step(int(0.9 * peak / 0.03e-3))
    assert desk.mode == R
    desk.step(int(0.2 * peak / 0.03e-3))
    assert (desk.mode, desk.cause) == (V, Cause.RESTED)
