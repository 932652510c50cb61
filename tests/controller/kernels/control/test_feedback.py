"""The feedback law, its limits and its switches, on the twin."""

import math

import numpy as np
import pytest

from controller.assembly.controllers.registry import index_of
from controller.kernels.control.feedback import told_of_tip
from controller.kernels.control.task_space import update_sensitivity
from controller.kernels.control.task_space_pi import FORGET_WAY, U_INT
from controller.reference.feasible.reach import static_tips
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.layout import to_record
from controller.schema.modes import Law, Mode, Request, RowKind
from controller.schema.parameters import SENSORS, ControllerParameters, Settings
from controller.simulation.run import plan
from tests.controller.statically import sensitivity, side_of
from tests.controller.trial import SOFT, Trial, controller_with, distance, true_tip, twin_with

pytestmark = pytest.mark.keyed()

POSES = {
    "P1": [(0.10, 0.14), (0.02, -0.16), (0.12, 0.10), (0.0, 0.10), (0.19, -0.09)],
    "P2": [(0.10, 0.14), (0.05, -0.12), (0.12, 0.08), (-0.02, 0.08)],
    "P3": [(0.08, 0.12), (0.03, -0.12), (0.10, 0.08), (0.0, 0.10)],
}


def paper_torque(trial: Trial, law: Law, error: np.ndarray, integral: np.ndarray, p_ref_dot: np.ndarray) -> np.ndarray:
    """u_FB of the paper by dense algebra."""
    K_P, K_I, K_FF = (np.diag(getattr(trial.settings, name)) for name in ("K_P", "K_I", "K_FF"))
    P, I = law in (Law.FF_P, Law.FF_PI), law in (Law.FF_I, Law.FF_PI)  # noqa: E741
    f = P * K_P @ error + I * K_I @ integral + K_FF @ p_ref_dot
    control = trial.rig.control
    S = np.array(sensitivity(control.smap.statics, control.q[2])).reshape(2, 2)
    assert np.linalg.cond(S) < 4
    return np.asarray(np.linalg.solve(S.T @ S + 1e-8 * np.eye(2), S.T @ f))


PAPER, LETTER = index_of("paper"), index_of("letter")


def kept_torque(trial: Trial) -> np.ndarray:
    """The integral's torque (2,) [N m]."""
    return trial.rig.control.slot.memory[U_INT : U_INT + 2].copy()


@pytest.mark.parametrize("law", [Law.FF_P, Law.FF_I, Law.FF_PI])
def test_the_feedback_is_the_paper_s_law(law: Law) -> None:
    gains = {"K_P": (0.3, 0.2), "K_I": (0.5, 0.6), "K_FF": (0.05, 0.04)}
    trial = Trial(law=law, controller=LETTER, **gains)
    trial.arm()
    trial.follow(0.10, 0.14, 3.0)
    trial.rig.control.controller["weak_ratio_live"] = 0.0  # begun with it, it saturates on noise
    trial.ask(Request.HOLD, ticks=100)
    p_ref = trial.rig.control.state[0]["p_ref"].copy()
    way = np.sin(np.pi * np.arange(5000) / 1000)[:, None]
    plan(trial.rig.control, Reference("about", p_ref + way * [-0.02, -0.01], 0))
    now = trial.ask(Request.TRACK, ticks=4200)[-1]  # the bump of the switch has faded
    expected = paper_torque(trial, law, now["error"], now["integral"], now["p_ref_dot"])
    assert np.abs(now["p_ref_dot"]).max() > 0.01
    assert now["u_fb"] == pytest.approx(expected, abs=1e-8)
    assert now["u"] == pytest.approx(now["u_ff"] + now["u_fb"], abs=1e-15)


def test_where_the_tip_is_led_the_torque_of_the_integral_is_kept_and_no_switch_makes_it_jump() -> None:
    """S of an arm that is led fast, or swings, turned a constant integral into a torque that swings."""
    trial = Trial(law=Law.FF_I)
    trial.arm()
    trial.follow(0.10, 0.14, 3.0)
    state, settings = trial.rig.control.state[0], trial.settings
    kept = kept_torque(trial)
    assert np.abs(kept).max() > 1e-3
    trial.switch(K_I=(1e-9, 1e-9))  # collects nothing more
    rows = trial.follow(0.15, 0.15, 2.0)
    assert kept_torque(trial) == pytest.approx(kept, abs=1e-6)
    assert rows["u_fb"][-1] == pytest.approx(kept, abs=1e-6)
    trial.switch(K_I=settings.K_I)
    before = trial.ask(Request.HOLD, ticks=100)[-1]
    assert np.reshape(state["S"], (2, 2)) @ kept_torque(trial) == pytest.approx(
        settings.K_I * before["integral"], abs=1e-4
    )
    plan(trial.rig.control, Reference("here", np.tile(before["p_ref"], (500, 1)), 0))
    rows = np.concatenate([before[None], trial.ask(Request.TRACK, ticks=300), trial.ask(Request.HOLD, ticks=100)])
    assert np.abs(np.diff(rows["u"], axis=0)).max() < 0.2e-3


def test_p_and_i_have_the_share_that_the_outermost_marker_tells_of_the_tip_where_the_tip_is_led() -> None:
    ours, paper = (to_record(ControllerParameters(**more))[0] for more in ({}, {"full_gains_from": 0.0}))
    shares = [round(told_of_tip(1 << sensor, ours), 4) for sensor in range(SENSORS)]
    assert shares == [0.25, 0.25, 0.25, 0.4444, 0.6944, 1.0, 1.0, 1.0, 1.0, 1.0]
    assert told_of_tip(0b1001, ours) == told_of_tip(0b1000, ours) and told_of_tip(0, ours) == 0.25
    assert [told_of_tip(used, paper) for used in (0, 1, 1 << 9)] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(("mode", "controller"), [(Mode.HOLD, PAPER), (Mode.TRACK, PAPER), (Mode.TRACK, LETTER)])
def test_a_marker_near_the_base_corrects_slowly_but_by_the_letter_a_planned_tip_in_full(
    mode: Mode, controller: int
) -> None:
    torques = []
    for full in (0.6, 0.0):
        trial = Trial(
            parameters=controller_with(full_gains_from=full), sensed=1 << 2, law=Law.FF, controller=controller
        )
        trial.arm()
        trial.follow(0.10, 0.14, 3.0)
        trial.ask(Request.HOLD, ticks=100)
        state = trial.rig.control.state[0]
        plan(trial.rig.control, Reference("here", np.tile(state["p_ref"], (500, 1)), 0))
        if mode == Mode.TRACK:
            trial.ask(Request.TRACK, ticks=10)
        trial.switch(law=Law.FF_I)
        trial.run(3)
        torques.append(kept_torque(trial))
    told = 1.0 if controller == LETTER else 0.25
    assert torques[0] == pytest.approx(told * torques[1], rel=1e-3) and np.abs(torques[1]).max() > 1e-6


@pytest.mark.parametrize("name", PRESETS)
def test_held_targets_are_reached_to_a_millimetre_with_one_gain_set(name: str) -> None:
    for x, y in POSES[name]:
        trial = Trial(name)
        trial.arm()
        rows = trial.follow(x, y, 12.0)
        assert rows["reachable"][-1] == 1
        steady = (true_tip(rows) - rows["p_ref"])[-1000:].mean(axis=0)
        assert np.linalg.norm(steady) < 1e-3


@pytest.mark.parametrize("name", PRESETS)
def test_the_loop_is_stable_with_half_as_much_gain_more_and_15_ms_more_dead_time(name: str) -> None:
    gains = {key: tuple(1.5 * k for k in getattr(Settings(), key)) for key in ("K_P", "K_I")}
    for x, y in POSES[name]:
        trial = Trial(parameters=twin_with(name, dead_time=0.065), **gains)
        trial.arm()
        tip = true_tip(trial.follow(x, y, 10.0))[-2000:]
        assert np.ptp(tip, axis=0).max() < 1e-3


def test_holding_the_straight_pose_is_quiet() -> None:
    """Nothing can move the tip along x there; the paper's law alone saturates on noise."""
    trial = Trial()
    trial.arm()
    rows = trial.run(10_000)
    assert (rows["mode"] == Mode.HOLD).all()
    assert np.abs(rows["u"]).max() < 1e-3
    paper = Trial(parameters=controller_with(weak_ratio_live=0.0))
    paper.arm()
    assert paper.run(3000)["saturated"].any()


def test_the_integral_is_no_further_than_the_edge_while_saturated_and_the_loop_recovers() -> None:
    """It is not collected, and what was collected on the way loses what is cut away."""
    trial = Trial(parameters=twin_with(**SOFT | {"torque_gain": (0.7, 0.7)}), law=Law.FF_I, K_I=(0.9, 0.9))
    trial.arm()
    rows = trial.follow(-0.02, 0.08, 8.0)
    clamped = np.flatnonzero(rows["saturated"])
    assert clamped.size > 3000
    assert np.isfinite(rows["u"]).all()
    polygon = trial.rig.control.smap.polygon
    assert ((rows["u"] @ polygon.normals.T) <= polygon.bounds * (1 + 1e-9)).all()
    late = clamped[clamped > 4000]
    beyond = np.abs(rows["u_ff"] + rows["u_fb"] - rows["u"])
    assert beyond.max() > 1e-4 and beyond[late].max() < 1e-5
    assert np.ptp(rows["u_fb"][-2000:], axis=0).max() < 1e-5, "it stands still there"
    back = trial.follow(0.12, 0.12, 10.0)
    assert not back["saturated"][1000:].any()
    assert distance(true_tip(back)[-500:], back["p_ref"][-500:]).mean() < 3e-3


@pytest.mark.parametrize("law", [Law.FF, Law.FF_PI])
def test_arming_starts_from_no_torque_and_does_not_jump(law: Law) -> None:
    trial = Trial(law=law)
    trial.run(100)
    rows = trial.ask(Request.ARM, ticks=500)
    assert (rows["u"][0] == 0.0).all()
    assert np.abs(np.diff(rows["u"], axis=0)).max() < 1e-5
    if law == Law.FF:
        assert rows["p_ref"][0] == pytest.approx((0.253, 0.0))
    else:
        assert distance(rows["p_ref"][0], true_tip(rows)[0]) < 5e-4, "where the arm is, not where the model rests"


SWITCHES = [
    {"law": Law.FF},
    {"law": Law.FF_P},
    {"law": Law.FF_I},
    {"law": Law.OPEN_LOOP, "u_open": (0.01, 0.01)},
    {"K_P": (0.6, 0.6)},
    {"K_I": (0.0, 2.0)},
    {"sensed": 1 << 5},
    {"sensed": 0},
]


@pytest.mark.parametrize("change", SWITCHES, ids=str)
def test_a_switch_does_not_make_the_torque_jump(change: dict[str, object]) -> None:
    trial = Trial(parameters=twin_with(**SOFT | {"torque_gain": (0.9, 0.9)}))
    trial.arm()
    rows = [trial.follow(0.10, 0.14, 1.5)]
    assert np.abs(rows[0]["u_fb"][-1]).max() > 2e-3
    trial.switch(**change)
    rows.append(trial.run(1000))
    trial.switch(**{key: getattr(Settings(), key) for key in change})
    rows.append(trial.run(3000))
    all_rows = np.concatenate(rows)
    step = np.abs(np.diff(all_rows["u"], axis=0)).max(axis=1)
    assert step[1499:1510].max() <= 0.5e-3 + 1e-12
    assert step[2499:2510].max() < 0.2e-3
    assert distance(true_tip(rows[2])[-200:], rows[2]["target"][-200:]).mean() < 8e-3


def test_an_open_loop_moves_at_its_rate_and_only_while_following() -> None:
    trial = Trial(law=Law.OPEN_LOOP, u_open=(0.02, -0.01))
    trial.arm()
    assert not trial.run(500)["u"].any()
    rows = trial.follow(0.1, 0.1, 1.0)
    assert np.abs(np.diff(rows["u"], axis=0)).max() == pytest.approx(0.5e-3)
    assert rows["u"][-1] == pytest.approx((0.02, -0.01))
    assert not rows["u_fb"].any()
    trial.ask(Request.HOLD)
    trial.switch(u_open=(0.0, 0.0))
    assert trial.run(500)["u"][-1] == pytest.approx((0.02, -0.01))


BEYOND = [("P1", (0.0, 0.30)), ("P1", (-0.1, 0.25)), ("P2", (0.0, 0.30)), ("P2", (0.1, 0.30)), ("P3", (0.0, 0.25))]


@pytest.mark.parametrize(("name", "target"), BEYOND)
def test_a_target_thrown_out_of_reach_leaves_the_tip_quiet_at_the_edge(name: str, target: tuple[float, float]) -> None:
    """The edge is a fold, where feedback that fades too late swings over the whole stroke."""
    trial = Trial(name, speed_max=1.0, acceleration_max=10.0)
    trial.arm()
    trial.follow(0.1, 0.1, 3.0)
    rows = trial.follow(*target, 8.0)
    assert (rows["mode"] == Mode.FOLLOW).all() and not rows["reachable"][-1]
    assert np.ptp(true_tip(rows)[-2000:], axis=0).max() < 2e-3


def test_across_a_fold_feedback_does_not_lead_on_into_the_other_pose() -> None:
    """S of the arm's own pose points there; along its weak direction the feedforward alone leads back."""
    rig = Trial().rig
    control, state, smap = rig.control, rig.control.state[0], rig.control.smap
    here, across = (0.045, -0.005), (0.045, -0.016)
    state["mode"] = Mode.TRACK
    assert side_of(smap.statics, *here) * side_of(smap.statics, *across) < 0.0
    for u in (here, across):
        control.q[2] = smap.statics.rest + smap.statics.compliance @ np.array(u)
        shares = []
        for kind, u_ff in [(RowKind.DRAWN, here), (RowKind.DRAWN, across), (RowKind.KNOWN, here)]:
            state["kind"], state["u_ff"] = kind, u_ff
            update_sensitivity(control)
            shares.append(float(state["share"]))
        same, other = (0, 1) if u == here else (1, 0)
        assert shares[same] > 0.0 and shares[other] == 0.0 and shares[2] >= shares[same]


@pytest.mark.parametrize("kind", [RowKind.TRAVEL, RowKind.DRAWN])
def test_on_the_way_to_another_pose_the_integral_of_the_one_that_is_left_is_forgotten(kind: RowKind) -> None:
    trial = Trial()
    trial.arm()
    trial.follow(0.10, 0.14, 3.0)
    before = trial.ask(Request.HOLD, ticks=500)[-1]
    u = before["u_ff"] * np.linspace(1.0, 0.2, 5)[:, None]
    p = static_tips(trial.rig.control.smap, u)
    plan(trial.rig.control, Reference("away", p, 0, u=u, travel=np.full(5, kind == RowKind.TRAVEL)))
    after = trial.ask(Request.TRACK, ticks=5)[-1]
    way = np.hypot(*np.diff(p, axis=0).T).sum()
    share = math.exp(-way / FORGET_WAY) if kind == RowKind.TRAVEL else 1.0
    grown = 5e-3 * way
    assert after["integral"] == pytest.approx(share * before["integral"], abs=grown)
    assert (1.0 - math.exp(-way / FORGET_WAY)) * np.hypot(*before["integral"]) > 2.0 * grown


def test_what_was_no_number_before_an_arming_is_none_after_it() -> None:
    trial = Trial()
    trial.run(100)
    state = trial.rig.control.state[0]
    state["S"] = trial.rig.control.slot.memory[:] = math.nan
    rows = np.concatenate([trial.ask(Request.ARM, ticks=100), trial.follow(0.2, 0.1, 1.0)])
    assert (rows["mode"][-1000:] == Mode.FOLLOW).all() and np.isfinite(rows["u"]).all()
