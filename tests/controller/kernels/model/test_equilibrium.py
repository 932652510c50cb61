"""The static pose under gravity, tip load and rest curvature, against minima of an energy written down again here."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize
from typer.testing import CliRunner

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.assembly.statics import build_static_map, build_statics, static_map
from controller.kernels.control.inverse import TOLERANCE
from controller.kernels.model.equilibrium import make_scratch, out_of_balance
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import Statics, static_pose
from controller.reference.feasible.reach import reach_map, static_tips
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import ControllerParameters, RigParameters
from server.cli.main import app
from tests.controller.statically import invert, require_slopes, sensitivity, static_angles, static_tip
from tests.docs.blocks import rows_after

pytestmark = pytest.mark.keyed("server/cli/research/commands.py", "docs/actuators.md")

HANGING, LYING = (9.81, 0.0), (0.0, -9.81)
U_MAX = 0.06


def loaded(name: str, gravity: tuple[float, float], rods: int = 10, load: float = 0.03) -> RodModel:
    update = {"gravity": gravity, "tip_load": load, "rest_curvature": (2.0, -1.0)}
    return build_rod(PRESETS[name].model_copy(update=update), rods)


def energy(model: RodModel, u: Array, theta: Array) -> float:
    """Springs, weights at their centres, torques [J]: nothing of the kernel's own form."""
    along = np.array([np.cos(theta), np.sin(theta)])
    ends = np.cumsum(model.L * along, axis=1)
    centres = ends - (model.L - model.arm) * along
    turns = np.diff(theta, prepend=0.0) - model.bend
    return float(0.5 * model.k @ turns**2 - model.m @ (model.g @ centres) - theta @ model.T_theta @ u)


def lowest(model: RodModel, u: Array, start: Array) -> Array:
    """The energy's minimum nearest to `start`, by a quasi-Newton method with numerical slopes."""
    scale = 1.0 / model.k.mean()
    found = minimize(lambda theta: scale * energy(model, u, theta), start, method="BFGS", options={"gtol": 1e-9})
    return np.asarray(found.x)


def tip(model: RodModel, theta: Array) -> Array:
    return np.array([model.L @ np.cos(theta), model.L @ np.sin(theta)])


def led(model: RodModel, u: Array) -> Array:
    """The minimum that follows from the rest as u_1 rises, then u_2."""
    theta = model.rest
    for share in np.linspace(0.1, 1.0, 10):
        theta = lowest(model, np.array([share * u[0], 0.0]), theta)
    for share in np.linspace(0.1, 1.0, 10):
        theta = lowest(model, np.array([u[0], share * u[1]]), theta)
    return theta


@pytest.mark.parametrize("gravity", [HANGING, LYING, (4.0, -7.0)])
@pytest.mark.parametrize("name", PRESETS)
def test_the_pose_is_the_minimum_of_energy_that_follows_from_the_rest(name: str, gravity: tuple[float, float]) -> None:
    model = loaded(name, gravity)
    statics, random = build_statics(model, U_MAX), np.random.default_rng(1)
    for u in [*random.uniform(-U_MAX, U_MAX, (3, 2)), np.array([U_MAX, -U_MAX])]:
        assert static_tip(statics, *u) == pytest.approx(tip(model, led(model, u)), abs=1e-6)


@pytest.mark.parametrize("rods", [2, 3, 40])
def test_any_number_of_rods_ends_in_a_minimum(rods: int) -> None:
    model = loaded("P1", HANGING, rods)
    statics, random = build_statics(model, U_MAX), np.random.default_rng(2)
    for u in random.uniform(-U_MAX, U_MAX, (3, 2)):
        found = static_tip(statics, *u)
        near = lowest(model, u, static_angles(statics, *u) + random.normal(0.0, 0.01, rods))
        assert found == pytest.approx(tip(model, near), abs=1e-6)


def test_a_thousand_rods_are_in_balance_to_rounding() -> None:
    statics, scratch = build_statics(loaded("P2", LYING, 1000), U_MAX), make_scratch(1000)
    static_pose(statics, 0.05, -0.02, scratch)
    assert out_of_balance(statics.body, 0.05, -0.02, scratch) < 1e-9


@pytest.mark.parametrize("gravity", [HANGING, LYING])
def test_sensitivity_and_curvature_are_those_of_the_true_equilibrium(gravity: tuple[float, float]) -> None:
    statics = build_statics(loaded("P2", gravity), U_MAX)
    for u in np.random.default_rng(3).uniform(-U_MAX, U_MAX, (5, 2)):
        require_slopes(statics, u)


def test_a_pose_depends_on_its_torques_alone() -> None:
    statics, scratch = build_statics(loaded("P2", LYING), U_MAX), make_scratch(10)
    static_pose(statics, 0.02, 0.01, scratch)
    first = scratch.theta.copy()
    for u in np.random.default_rng(4).uniform(-U_MAX, U_MAX, (50, 2)):
        static_pose(statics, *u, scratch)
    static_pose(statics, 0.02, 0.01, scratch)
    assert np.array_equal(scratch.theta, first)


def test_torques_that_are_no_numbers_have_a_pose_that_is_none() -> None:
    statics = build_statics(loaded("P1", HANGING), U_MAX)
    assert np.isnan(static_tip(statics, np.nan, 0.0)).all()
    assert np.isfinite(static_tip(statics, 1e3, -1e3)).all()


def test_threads_that_share_a_map_get_the_tips_of_one_alone() -> None:
    smap = static_map(hanging(), ControllerParameters())
    u = np.random.default_rng(5).uniform(-0.03, 0.03, (4, 5000, 2))
    alone = [static_tips(smap, some) for some in u]
    with ThreadPoolExecutor(4) as pool:
        assert np.array_equal(list(pool.map(lambda some: static_tips(smap, some), u)), alone)


def hanging(name: str = "P1", **changes: object) -> Actuator:
    return PRESETS[name].model_copy(update={"gravity": HANGING, "tip_load": 0.02, **changes})


@pytest.mark.parametrize("gravity", [HANGING, LYING])
@pytest.mark.parametrize("name", PRESETS)
def test_under_gravity_every_admissible_torque_keeps_to_the_bend_limit(name: str, gravity: tuple[float, float]) -> None:
    actuator = hanging(name, gravity=gravity, bend_max=2.5)
    smap = build_static_map(build_rod(actuator, 10), actuator, ControllerParameters())
    bends = []
    for u in reach_map(RigParameters(actuator=actuator), 31).u.reshape(-1, 2):
        bends.append(abs(static_angles(smap.statics, *u)[-1] - smap.statics.rest[-1]))
    assert 0.8 * actuator.bend_max < max(bends) < 1.02 * actuator.bend_max


@pytest.mark.parametrize("name", PRESETS)
def test_the_inverse_finds_the_torques_of_a_hanging_arm(name: str) -> None:
    smap = static_map(hanging(name), ControllerParameters())
    for k in np.random.default_rng(6).integers(0, len(smap.seeds), 100):
        u = 0.95 * smap.seeds[k]
        now, target = (u[0] + 2e-3, u[1] - 2e-3), static_tip(smap.statics, *u)
        for _ in range(5):
            u1, u2, left = invert(smap, target, now, False)
            now = (u1, u2)
        assert left < TOLERANCE


def cantilever(rods: int, gravity: tuple[float, float], u: tuple[float, float]) -> Array:
    """Tip of a tapered backbone given by its EI."""
    known = {"name": "rod", "mass": 0.125, "length": 0.253, "EI": (3e-3, 1.5e-3, 1e-3), "EI_arc": (0.0, 0.1, 0.253)}
    actuator = Actuator.model_validate({**known, "beta": 2e-3, "gravity": gravity})
    return np.array(static_tip(build_statics(build_rod(actuator, rods), U_MAX), *u))


@pytest.mark.parametrize("gravity, u", [(LYING, (0.0, 0.0)), (HANGING, (0.02, 0.01))])
def test_joints_from_EI_are_of_second_order(gravity: tuple[float, float], u: tuple[float, float]) -> None:
    exact = cantilever(800, gravity, u)
    off = [np.linalg.norm(cantilever(rods, gravity, u) - exact) for rods in (20, 40, 80)]
    assert 3.5 < off[0] / off[1] < 4.6
    assert 3.5 < off[1] / off[2] < 4.6
    assert off[0] < 1e-3


def test_a_hanging_cantilever_given_by_EI_is_the_heavy_elastica() -> None:
    """Against (EI theta')' + w (L - s) cos theta = 0, theta(0) = 0, theta'(L) = 0, solved by collocation."""
    from scipy.integrate import solve_bvp

    EI, length, weight = 1.9e-3, 0.253, 0.125 * 9.81 / 0.253
    s = np.linspace(0.0, length, 200)
    found = solve_bvp(
        lambda s, y: np.array([y[1], -weight * (length - s) * np.cos(y[0]) / EI]),
        lambda a, b: np.array([a[0], b[1]]),
        s,
        np.array([np.arctan(20.0 * s), 20.0 / (1.0 + (20.0 * s) ** 2)]),
        tol=1e-8,
    )
    theta = found.sol(np.linspace(0.0, length, 20001))[0]
    expected = np.trapezoid([np.cos(theta), np.sin(theta)], dx=length / 20000)
    known = {"name": "rod", "mass": 0.125, "length": length, "EI": EI, "beta": 2e-3, "gravity": (0.0, 9.81)}
    model = build_rod(Actuator.model_validate(known), 200)
    assert static_tip(build_statics(model, U_MAX), 0.0, 0.0) == pytest.approx(expected, abs=2e-5)


def test_the_command_says_tip_angles_sensitivity_and_residual(tmp_path: Path) -> None:
    file = tmp_path / "statics.json"
    order = ["statics", "--actuator", "P2", "--rods", "7", "--u", "-0.02,0.03", "--json", str(file)]
    assert CliRunner().invoke(app, order).exit_code == 0
    found = json.loads(file.read_text())
    model = build_rod(PRESETS["P2"], 7)
    assert found["tip"] == pytest.approx(tip(model, lowest(model, np.array([-0.02, 0.03]), model.rest)), abs=1e-6)
    assert found["tip"] == pytest.approx(tip(model, np.array(found["angles"])), abs=1e-12)
    statics: Statics = build_statics(model, U_MAX)
    assert np.ravel(found["S"]) == pytest.approx(sensitivity(statics, np.array(found["angles"])))
    assert 0.0 <= found["residual"] < 1e-12
    assert found["admissible"]


@pytest.mark.parametrize("words, why", [("0.7,0", "u_1 = 0.7 N m is outside"), ("1", "is not two"), ("nan,0", "u_1")])
def test_torques_that_make_no_sense_are_refused_with_their_bound(words: str, why: str) -> None:
    answer = CliRunner().invoke(app, ["statics", "--u", words])
    assert answer.exit_code != 0
    assert why in str(answer.exception)


def test_the_table_of_coarse_chains_says_what_they_cost() -> None:
    """docs/actuators.md, "Another number of rods": the worst over all admissible torques."""
    page = (Path(__file__).parents[4] / "docs/actuators.md").read_text()
    for row in rows_after(page, "## Another number of rods"):
        rods = int(row[0])
        assert [float(cell) for cell in row[1:]] == [pytest.approx(cost(name, rods), abs=0.06) for name in PRESETS]


def cost(name: str, rods: int) -> float:
    """How far the tips of `rods` are from those of the table's ten [mm], at most."""
    actuator = PRESETS[name]
    u = reach_map(RigParameters(actuator=actuator), 41).u
    tips = [static_tips(static_map(actuator, ControllerParameters(rods=n)), u) for n in (rods, 10)]
    return float(1e3 * np.linalg.norm(tips[0] - tips[1], axis=-1).max())
