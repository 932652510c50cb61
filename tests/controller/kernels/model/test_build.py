"""Models of any number of rods from the table for ten: the static map stays, and the fastest mode bounds the step."""

import math

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.rig import build_rig
from controller.assembly.rod import build_rod, torque_map
from controller.assembly.stability import largest_step, natural_modes, stable_substeps
from controller.assembly.twin import twin_model
from controller.errors import ParameterError
from controller.kernels.model.rod import RodModel, make_load
from controller.kernels.model.statics import at_rest
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import ControllerParameters, RigParameters, TwinParameters
from tests.controller.chains import advance, preset, static, thrown
from tests.controller.statically import static_tip
from tests.oracles import Chain

pytestmark = pytest.mark.keyed()

BASE_MID_TIP = PRESETS["P2"].model_copy(update={"chambers": ((1, 5), (5, 10))})


def admissible(actuator: Actuator, u_max: float) -> list[tuple[float, float]]:
    side, bend = np.linspace(-u_max, u_max, 21), preset(actuator.name).compliance[-1]
    return [(u1, u2) for u1 in side for u2 in side if abs(bend @ (u1, u2)) <= actuator.bend_max]


def tips(model: RodModel, torques: list[tuple[float, float]]) -> Array:
    found = static(model)
    return np.array([static_tip(found, *u) for u in torques])


def test_ten_rods_have_the_papers_table() -> None:
    P1, P2 = preset("P1"), preset("P2")
    assert P1.k == pytest.approx(np.full(10, 0.0751), rel=1e-12)
    assert P2.k == pytest.approx(np.linspace(0.0664, 0.0248, 10), rel=1e-12)
    assert P2.b == pytest.approx(np.linspace(0.767e-3, 0.205e-3, 10), rel=1e-12)
    assert pytest.approx(0.1445) == P2.m.sum()
    expected = np.zeros((10, 2))
    expected[4], expected[9] = (1.0, -1.0), (0.0, 1.0)
    assert np.array_equal(P1.T_theta, expected)
    assert torque_map(BASE_MID_TIP, 10)[0].tolist() == [-1.0, 0.0]


@pytest.mark.parametrize(
    ("name", "worst", "gentle"), [("P1", 4.8e-3, 1.4e-3), ("P2", 15e-3, 4e-3), ("P3", 3.8e-3, 1e-3)]
)
@pytest.mark.parametrize("rods", [14, 15, 20, 100, 1000])
def test_the_static_map_does_not_depend_on_the_number_of_rods(
    name: str, worst: float, gentle: float, rods: int
) -> None:
    """At full torque 10 rods turn by up to 0.8 rad (P2: 2.4) a joint: that polygon is not the smooth curve."""
    for u_max, bound in ((PRESETS[name].u_max, worst), (0.02, gentle)):
        torques = admissible(PRESETS[name], u_max)
        apart = np.linalg.norm(tips(preset(name, rods), torques) - tips(preset(name), torques), axis=1)
        assert apart.max() < bound


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_at_full_bend_the_tip_stays_within_five_millimetres_for_every_number_of_rods(name: str) -> None:
    """Both chambers at the bend limit, either way. Two to four rods are too coarse a polygon for nearly a full turn."""
    u = PRESETS[name].bend_max / preset(name).compliance[-1].sum()
    torques = [(u, u), (-u, -u)]
    few = {"P1": (13e-3, 5e-3, 3e-3), "P2": (40e-3, 14e-3, 6.1e-3), "P3": (10e-3, 4e-3, 2e-3)}[name]
    for rods in (*range(2, 40), 100, 317, 1000):
        apart = np.linalg.norm(tips(preset(name, rods), torques) - tips(preset(name), torques), axis=1)
        assert apart.max() < (5e-3 if rods > 4 else few[rods - 2]), rods


def test_angles_at_the_middles_of_the_tables_rods_are_kept_exactly() -> None:
    """30 rods have a middle wherever 10 have one."""
    fine, table = preset("P2", 30), preset("P2")
    assert fine.compliance[1::3] == pytest.approx(table.compliance, rel=1e-12)


@pytest.mark.parametrize("actuator", [PRESETS["P2"], BASE_MID_TIP])
def test_the_compliance_solves_the_dense_stiffness(actuator: Actuator) -> None:
    model = build_rod(actuator, 14)
    dense = np.linalg.solve(Chain(model).hinges(model.k), model.T_theta)
    assert model.compliance == pytest.approx(dense, rel=1e-12, abs=1e-12)


def test_the_model_at_rest_settles_where_the_static_map_says() -> None:
    model, u, load = preset("P1", alpha=5.0), np.array([0.02, 0.015]), make_load(10)
    load.Q_theta[:] = model.T_theta @ u
    state = advance(model, at_rest(model), load, 20.0)
    assert state.q[2] == pytest.approx(model.compliance @ u, rel=1e-8)


def test_a_fine_chain_has_the_first_frequency_of_a_clamped_beam() -> None:
    rods, EI = 100, 0.0751 * 0.253 / 10
    length = 0.253 / rods
    k = np.full(rods, EI / length)
    k[0] = 2 * EI / length  # a real clamp: half a cell at the base
    model = preset("P1", rods, k=k, b=np.zeros(rods), alpha=0.0)
    omega = np.abs(natural_modes(model, np.zeros(rods))).min()
    assert omega == pytest.approx(3.516 * math.sqrt(EI / (0.125 / 0.253 * 0.253**4)), rel=1e-3)


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_the_twins_first_mode_is_damped_as_asked_and_rises_with_kappa(name: str) -> None:
    model = twin_model(PRESETS[name], TwinParameters(kappa=17.4, zeta=0.3))
    modes = natural_modes(model, model.rest)
    first = modes[np.argmin(np.abs(modes))]
    assert -first.real / abs(first) == pytest.approx(0.3, rel=1e-6)
    low, high = {"P1": (2.0, 2.4), "P2": (1.5, 2.0), "P3": (3.3, 4.0)}[name]
    assert low < abs(first) / (2 * math.pi) < high


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_the_largest_step_is_where_the_integrator_begins_to_diverge(name: str) -> None:
    model = preset(name)
    bound = largest_step(model)
    assert peak_speed(model, 0.97 * bound) < 1.0
    assert not peak_speed(model, 1.05 * bound) < 1.0


def peak_speed(model: RodModel, dt: float) -> float:
    """Speed left after 4000 steps from a small throw about the straight pose."""
    state = advance(model, thrown(model, 0, bend=1e-6, speed=1e-4), make_load(10), 4000 * dt, dt)
    return float(np.abs(state.v).max())


@pytest.mark.parametrize("rods", [1, 1001])
def test_a_number_of_rods_out_of_bounds_is_named(rods: int) -> None:
    with pytest.raises(ParameterError, match=rf"rods = {rods} is outside \[2, 1000\]"):
        preset("P1", rods)


def test_finer_rods_need_substeps() -> None:
    assert stable_substeps(preset("P1"), 1e-3) == 1
    assert stable_substeps(preset("P1", 20), 1e-3) in range(6, 12)
    assert stable_substeps(build_rod(PRESETS["P2"], 20), 1e-3) in range(18, 32)


def test_a_rig_that_would_take_longer_than_a_minute_to_come_to_rest_does_not_start() -> None:
    """Each watchdog's time is bounded; what comes after it was not, and a rig no one serves kept its pressure."""
    for rate, seconds in ((1e-9, r"6e\+07"), (0.99e-3, "60.61")):
        with pytest.raises(ParameterError, match=rf"rest_rate = {rate:g} N m/s takes {seconds} s .* u_max = 0.06 N m"):
            build_rig(RigParameters(controller=ControllerParameters(rest_rate=rate)), 1)
    build_rig(RigParameters(controller=ControllerParameters(rest_rate=1e-3)), 1)
