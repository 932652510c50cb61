"""The static inverse, its branches and the reference, against scipy and brute force."""

import itertools
from functools import cache

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from controller.assembly.statics import build_static_map
from controller.kernels.control.follow import branch_due, limit_motion
from controller.kernels.control.inverse import MARGIN, REFINE_STEPS, STARTS, TOLERANCE, gauss_newton
from controller.kernels.control.timing import feedforward_ticks
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.polygon import admissible, nearest_admissible
from controller.kernels.model.statics import StaticMap, tips_of
from controller.schema.actuator import PRESETS
from controller.schema.layout import to_record
from controller.schema.modes import Law, Mode, Request
from controller.schema.parameters import ControllerParameters, RigParameters, Settings
from tests.controller.chains import preset
from tests.controller.desk import Desk
from tests.controller.statically import expand_tip, invert, refine, static_tip
from tests.controller.trial import Trial, distance, line, true_tip

pytestmark = pytest.mark.keyed()


@cache
def static_map(name: str = "P1") -> StaticMap:
    return build_static_map(preset(name), PRESETS[name], ControllerParameters())


def random_torques(smap: StaticMap, count: int, seed: int) -> list[tuple[float, float]]:
    draw = np.random.default_rng(seed).uniform(-0.06, 0.06, (10 * count, 2))
    return [(u1, u2) for u1, u2 in draw if admissible(smap.polygon, u1, u2)][:count]


def settle(smap: StaticMap, target: tuple[float, float], u: tuple[float, float]) -> tuple[float, float, float]:
    """As many updates as the inverse needs, one a tick."""
    for _ in range(50):
        u1, u2, left, settled = refine(smap, target, u, REFINE_STEPS)
        if settled:
            return u1, u2, left
        u = (u1, u2)
    raise AssertionError(f"not settled at {u}, {left} m from {target}")


def test_the_step_is_the_paper_s_gauss_newton_step() -> None:
    smap, r = static_map(), np.array([0.01, -0.02])
    at = expand_tip(smap.statics, 0.02, -0.01)
    S = np.array([[at.x_1, at.x_2], [at.y_1, at.y_2]])
    assert gauss_newton(smap, at, *r) == pytest.approx(-np.linalg.solve(S, r))
    straight = expand_tip(smap.statics, 0.0, 0.0)
    S = np.array([[straight.x_1, straight.x_2], [straight.y_1, straight.y_2]])
    regular = -np.linalg.solve(S.T @ S + 1e-8 * np.eye(2), S.T @ r)
    assert np.linalg.cond(S) > 1e10
    assert gauss_newton(smap, straight, *r) == pytest.approx(regular, rel=1e-4)


@pytest.mark.parametrize("name", PRESETS)
def test_projection_finds_the_nearest_admissible_torque(name: str) -> None:
    polygon = static_map(name).polygon
    limits = LinearConstraint(1e2 * polygon.normals / polygon.bounds[:, None] / 1e2, -np.inf, 1)
    for u in np.random.default_rng(3).uniform(-0.2, 0.2, (40, 2)):
        nearest = nearest_admissible(polygon, u[0], u[1])
        best = minimize(lambda v, u=u: 1e3 * np.sum((v - u) ** 2), np.zeros(2), constraints=limits, tol=1e-12).x
        assert admissible(polygon, nearest[0], nearest[1])
        assert np.linalg.norm(nearest - u) == pytest.approx(np.linalg.norm(best - u), abs=1e-6)


@pytest.mark.parametrize("name", PRESETS)
def test_the_inverse_settles_at_a_local_minimum_of_the_distance(name: str) -> None:
    smap = static_map(name)
    limits = LinearConstraint(1e-2 * smap.polygon.normals / smap.polygon.bounds[:, None], -np.inf, 1)
    targets = np.random.default_rng(5).uniform(-0.3, 0.3, (60, 2))
    for target, start in zip(targets, random_torques(smap, 60, 6), strict=True):
        u1, u2, left = settle(smap, (target[0], target[1]), start)
        assert admissible(smap.polygon, u1, u2)
        objective = lambda v, target=target: 1e3 * np.sum((static_tip(smap.statics, *(1e-2 * v)) - target) ** 2)  # noqa: E731
        best = minimize(objective, 1e2 * np.array([u1, u2]), constraints=limits, method="SLSQP", tol=1e-14)
        assert left <= np.sqrt(best.fun / 1e3) + TOLERANCE


@pytest.mark.parametrize("name", PRESETS)
def test_the_inverse_returns_the_torques_of_a_tip_near_them(name: str) -> None:
    smap = static_map(name)
    for u in random_torques(smap, 100, 8):
        near = nearest_admissible(smap.polygon, u[0] + 1e-3, u[1] - 1e-3)
        assert settle(smap, static_tip(smap.statics, *u), near)[2] < TOLERANCE


def test_a_target_straight_ahead_of_the_straight_pose_is_reached() -> None:
    """There S^T r = 0: Gauss-Newton alone would stay for ever."""
    for x in (0.2529, 0.24, 0.2):
        u1, u2, left = settle(static_map(), (x, 0.0), (0.0, 0.0))
        assert left < TOLERANCE
        assert max(abs(u1), abs(u2)) < 0.06


@pytest.mark.parametrize("name", PRESETS)
def test_every_tip_of_the_map_is_found_from_every_start(name: str) -> None:
    """Jump after jump, each from where the one before ended: the way may lead through folds and along edges."""
    smap, now = static_map(name), (0.0, 0.0)
    for u in random_torques(smap, 3000, 9):
        target = static_tip(smap.statics, u[0], u[1])
        for _ in range(20):
            u1, u2, left = invert(smap, target, now, True)
            now = (u1, u2)
            if left < TOLERANCE:
                break
        assert left < TOLERANCE, f"{target} is missed by {1e3 * left:.1f} mm"


@pytest.mark.parametrize("name", PRESETS)
def test_a_target_out_of_reach_leads_to_the_nearest_point_of_the_whole_reach(name: str) -> None:
    """Against the nearest tip of a fine grid, refined: warm from one random target to the next."""
    smap, now = static_map(name), (0.0, 0.0)
    side = np.linspace(-1.0, 1.0, 201) * smap.polygon.bounds[0]
    grid = np.array([u for u in itertools.product(side, side) if admissible(smap.polygon, *u)])
    tips = np.zeros_like(grid)
    tips_of(smap.statics, grid, make_scratch(10), tips)
    for target in np.random.default_rng(10).uniform(-0.3, 0.3, (300, 2)):
        for _ in range(20):
            u1, u2, left = invert(smap, (target[0], target[1]), now, True)
            now = (u1, u2)
        apart = np.linalg.norm(tips - target, axis=1)
        assert left < apart.min() + MARGIN, f"{target}: {1e3 * (left - apart.min()):.1f} mm beyond"


def test_the_branch_is_kept_while_it_reaches_the_target() -> None:
    """Two torques hold P1's tip near the x-axis; the inverse follows the one it is on, far into the other half."""
    smap = static_map()
    u = settle(smap, (0.2, 0.01), (0.012, -0.03))[:2]
    other = settle(smap, (0.2, 0.01), (-0.012, 0.03))[:2]
    assert distance(np.array(u), np.array(other)) > 0.02
    for y in np.linspace(0.01, -0.01, 40):
        before = u
        u1, u2, left = invert(smap, (0.2, y), u, True)
        u = (u1, u2)
        assert left < TOLERANCE
        assert distance(np.array(u), np.array(before)) < 2e-3


def test_a_limited_motion_stops_at_its_goal_without_overshoot() -> None:
    p, v, goal, limits, dt = (0.0, 0.0), (0.0, 0.0), (0.06, 0.08), (0.2, 1.5), 1e-3
    ticks = 0
    while p != goal or v != (0.0, 0.0):
        ticks, before = ticks + 1, v
        p, v = limit_motion(p, v, goal, limits, dt)
        assert np.hypot(*v) <= 0.2 * (1 + 1e-12)
        assert np.hypot(v[0] - before[0], v[1] - before[1]) <= 1.5 * dt * (1 + 1e-9)
        assert 0.6 * p[0] + 0.8 * p[1] <= 0.1 + 1e-6
    fastest = 0.1 / 0.2 + 0.2 / 1.5
    assert ticks * dt == pytest.approx(fastest, abs=0.01)


def test_a_lower_acceleration_set_on_the_way_does_not_overshoot_the_target() -> None:
    """Under 0.01 m/s^2 alone a wish of 1 m/s would need 50 m to stop."""
    trial = Trial(speed_max=1.0, acceleration_max=10.0)
    trial.arm()
    trial.follow(0.1, 0.12, 0.15)
    trial.switch(acceleration_max=0.01)
    rows = trial.run(12_000)
    left = distance(rows["p_ref"], rows["target"])
    assert left[0] > 0.05, "it is on its way"
    assert np.diff(left).max() < 1e-4 and left[-1] < 1e-3
    trial.command["target"] = (0.12, 0.11)
    rate = np.diff(trial.run(1000)["p_ref_dot"], axis=0) / 1e-3
    assert np.linalg.norm(rate, axis=1).max() < 0.011, "from rest the lower limit counts"


def test_a_target_out_of_reach_is_held_at_the_nearest_point_and_left_at_once() -> None:
    trial = Trial()
    trial.arm()
    rows = trial.follow(0.3, 0.14, 6.0)
    last = rows[-1]
    grid = static_map().seed_tips
    assert last["reachable"] == 0
    assert distance(last["p_ref"], last["target"]) <= distance(grid, last["target"]).min() + 1e-6
    assert distance(last["p_ref"], true_tip(rows)[-1]) < 5e-3
    back = trial.follow(0.15, 0.12, 1.0)
    assert distance(back["p_ref"][200], last["p_ref"]) > 10e-3
    assert back["reachable"][-1] == 1


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("x", [0.08, 0.17], ids=["across the hole", "across the rest axis"])
def test_a_dragged_target_crosses_without_a_jump_and_is_reached(name: str, x: float) -> None:
    trial = Trial(name, law=Law.FF)  # armed so, the reference begins on the rest axis, not beside it where the arm is
    trial.arm()
    trial.switch(law=Law.FF_PI)
    parts = [trial.follow(x, -0.08, 4.0), trial.drag(line((x, -0.08), (x, 0.08), 100), 2.0), trial.run(8000)]
    rows = np.concatenate(parts)
    assert np.isfinite(rows["u"]).all()
    assert distance(rows["p_ref"][1:], rows["p_ref"][:-1]).max() <= 0.21e-3
    assert np.abs(np.diff(rows["u_ff"], axis=0)).max() <= 0.5e-3 + 1e-12
    assert rows["mode"][-1] == 2
    assert rows["p_ref"][-1] == pytest.approx((x, 0.08), abs=1e-4)
    assert distance(true_tip(rows)[-500:], rows["p_ref"][-500:]).mean() < 6e-3


@pytest.mark.parametrize("period", [0.01, 0.1])
def test_between_two_solutions_the_reference_follows_the_torque_and_a_hold_stays_there(period: float) -> None:
    trial = Trial(feedforward_period=period)
    trial.arm()
    reference, plan = trial.rig.control.reference, trial.rig.control.plan
    reference[:2000], plan[0] = (0.16, 0.0), (2000, 0, 2000)
    trial.rig.control.guide[:2000] = np.nan
    begun = trial.ask(Request.TRACK)[-1]
    assert static_tip(trial.rig.control.smap.statics, *begun["u_ff"]) == pytest.approx(begun["p_ref"], abs=1e-4)
    trial.switch(law=Law.OPEN_LOOP)
    opened = trial.run(1)[-1]
    trial.switch(law=Law.FF_PI)
    closed = trial.run(1)[-1]
    assert closed["p_ref"].tolist() == opened["p_ref"].tolist(), "not where the plan is: nothing leads there yet"
    held = trial.ask(Request.HOLD, ticks=300)
    assert distance(held["p_ref"], opened["p_ref"]).max() < 2e-4


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 2e-3, 1e-2])
def test_every_other_branch_has_its_turn_however_often_the_inverse_is_solved(dt: float) -> None:
    for milliseconds in range(1, 101):
        settings = to_record(Settings(feedforward_period=1e-3 * milliseconds))[0]
        every = feedforward_ticks(settings, dt)
        ticks = every * np.arange(200)
        ranks = np.array([branch_due(tick, every) for tick in ticks])
        looks = np.flatnonzero(ranks >= 0)
        assert np.array_equal(ranks[looks], np.arange(len(looks)) % STARTS), milliseconds
        assert (np.diff(ticks[looks]) >= 10).all() and (np.diff(ticks[looks]) < 10 + every).all(), milliseconds


@pytest.mark.parametrize("every", [1, 2, 5, 10])
def test_where_ten_ticks_are_whole_periods_a_branch_is_looked_at_every_ten_ticks(every: int) -> None:
    for tick in range(0, 1000, every):
        assert branch_due(tick, every) == (tick // 10 % STARTS if tick % 10 == 0 else -1)


@pytest.mark.parametrize("period", [0.001, 0.01, 0.016, 0.02, 0.04, 0.1])
def test_the_only_branch_that_reaches_the_target_is_found_however_often_the_inverse_is_solved(period: float) -> None:
    """3 mm short of it, and only the second and the fourth start lead there: every 16, 20 or 40 ms none was tried."""
    desk = Desk(RigParameters(actuator=PRESETS["P2"]), law=Law.FF, K_o=(0.0, 0.0), feedforward_period=period)
    desk.rig.control.limits["residual_max"] = 1.0
    desk.into(Mode.HOLD)
    state, u = desk.rig.control.state[0], (30e-3, 15e-3)
    state["u"] = state["u_ff"] = u
    state["wish"] = state["p_ref"] = static_tip(desk.rig.control.smap.statics, *u)
    desk.ask(Request.FOLLOW, target=(-0.103, -0.078))
    assert not desk.rig.control.state["reachable"][0]
    desk.step(2500)
    assert desk.mode == Mode.FOLLOW and desk.rig.control.state["reachable"][0]
