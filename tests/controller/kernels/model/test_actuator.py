"""Actuators as data: the paper's table, a user's own file, and what a wrong file is told."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.assembly.plant import build_plant
from controller.assembly.plant_parts import chamber_gains
from controller.assembly.rig import build_rig
from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes
from controller.assembly.statics import build_statics, observer_model
from controller.assembly.twin import build_twin
from controller.errors import ParameterError
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import at_rest, tip_of
from controller.research.bench.mujoco_chain import MujocoChain
from controller.schema.actuator import PRESETS, Actuator, read_actuator, write_actuator
from controller.schema.messages import Command
from controller.schema.modes import Request
from controller.schema.parameters import ControllerParameters, PlantKind, RigParameters, TwinParameters
from controller.simulation.simulate import simulate
from tests.controller.chains import advance, posed
from tests.controller.statically import static_angles

pytestmark = pytest.mark.keyed()

LOADED = {"tip_load": 0.02, "gravity": (0.4, -0.1), "rest_curvature": (6.0, 2.0), "mass_profile": (2.0, 1.0)}
OWN = """
name = "my arm"
mass = 0.1
length = 0.2
k = [0.06, 0.03]
b = 0.2e-3
"""


def changed(**fields: Any) -> Actuator:
    return Actuator.model_validate(PRESETS["P1"].model_dump() | fields)


def written(folder: Path, text: str) -> Path:
    path = folder / "own.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("mass = -1", "mass = -1: Input should be greater than 0"),
        ("k = [0.1, 0.2, 0.3]", "k has 3 values: 1, 2 or table_rods = 10 are allowed"),
        ("k = [0.1, nan]", "k.1 = nan: Input should be"),
        ("stiffness = 3.0", "stiffness = 3.0: Extra inputs are not permitted"),
        ("chambers = [[0, 5], [5, 11]]", r"chambers \(5, 11\): first < second <= table_rods = 10"),
        ("u_max = 0.1", "u_max = 0.1 N m needs 402160 Pa, above pressure_max = 241300.0"),
        ("gravity = [0.0, 98.1]", "gravity.1 = 98.1: Input should be less than or equal to 20"),
        ('length = "long"', "length = long: Input should be a valid number"),
        ("tip_load = ", "is not TOML: .*line 5"),
    ],
)
def test_a_wrong_file_is_told_field_value_and_bound(tmp_path: Path, line: str, complaint: str) -> None:
    kept = [row for row in OWN.strip().splitlines() if row.split(" =")[0] != line.split(" =")[0]]
    with pytest.raises(ParameterError, match=complaint):
        read_actuator(written(tmp_path, "\n".join([*kept[:4], line, *kept[4:]])))


@pytest.mark.parametrize(
    ("frame", "complaint"),
    [
        ("base = [0.0, 0.0]\naxis = [0.0, 0.0]\narcs = [0.1]", "has no direction"),
        ("base = [0.0, nan]\naxis = [0.0, 1.0]\narcs = [0.1]", "tracking.base.1 = nan"),
        ("base = [0.0, 0.0]\naxis = [0.0, 1.0, 0.0]\narcs = [0.1]", "tracking: base has 2 coordinates, axis has 3"),
        ("base = [0.0, 0.0]\naxis = [1.0, 0.0]\narcs = [1.9]", r"tracking\.arcs ends at 1\.9 m, beyond the tip"),
    ],
)
def test_a_frame_of_tracked_bodies_that_cannot_be_is_refused(tmp_path: Path, frame: str, complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        read_actuator(written(tmp_path, f"{OWN}\n[tracking]\n{frame}\n"))


def test_a_byte_order_mark_is_read_over(tmp_path: Path) -> None:
    assert read_actuator(written(tmp_path, "\ufeff" + OWN)) == read_actuator(written(tmp_path, OWN))


def test_a_missing_field_or_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"own\.toml: mass: Field required"):
        read_actuator(written(tmp_path, OWN.replace("mass = 0.1", "")))
    with pytest.raises(ParameterError, match=r"none.toml cannot be read: .*No such file"):
        read_actuator(tmp_path / "none.toml")
    with pytest.raises(ParameterError, match=r"actuator = 'P9' is not one of P1, P2, P3 or a \.toml file"):
        read_actuator("P9")


@pytest.mark.parametrize("actuator", [PRESETS["P2"], changed(**LOADED, name="bent 2")])
def test_a_written_actuator_is_read_back(tmp_path: Path, actuator: Actuator) -> None:
    write_actuator(actuator, tmp_path / "a.toml", "fitted to nothing")
    assert read_actuator(tmp_path / "a.toml") == actuator
    text = (tmp_path / "a.toml").read_text()
    assert text.startswith("# fitted to nothing\n")
    assert "mass = " in text and "# kg" in text


def test_an_actuator_of_ones_own_is_armed_and_follows_its_target(tmp_path: Path) -> None:
    parameters = RigParameters(actuator=read_actuator(written(tmp_path, OWN)))
    target = (0.05, 0.12)
    follow = Command(boot=1, request=Request.FOLLOW, request_n=2, target=target)
    rows = simulate(
        build_rig(parameters, 1),
        build_twin(parameters),
        [(100, Command(boot=1, request=Request.ARM, request_n=1)), (300, follow)],
        8000,
    )
    assert np.linalg.norm(rows["p_meas"][-1] - target) < 2e-3


def test_the_tip_load_moves_mass_centre_and_inertia_of_the_last_rod() -> None:
    bare, loaded = build_rod(PRESETS["P1"], 10), build_rod(changed(tip_load=0.05), 10)
    assert loaded.m.sum() == pytest.approx(0.125 + 0.05)
    assert loaded.m[:-1] == pytest.approx(bare.m[:-1])
    about_hinge = bare.I[-1] + bare.m[-1] * bare.arm[-1] ** 2 + 0.05 * bare.L[-1] ** 2
    assert loaded.I[-1] + loaded.m[-1] * loaded.arm[-1] ** 2 == pytest.approx(about_hinge)


def test_a_tip_load_lowers_the_first_frequency_as_beam_theory_says() -> None:
    """omega^2 = 3 EI / (L^3 (M + 33/140 m)), Rayleigh's quotient, 1.5 % above the exact one without a load."""
    rods, EI, L, m, M = 100, 0.0751 * 0.0253, 0.253, 0.125, 0.25
    k = np.full(rods, EI * rods / L)
    k[0] *= 2.0  # a real clamp: half a cell at the base
    model = build_rod(changed(tip_load=M), rods)._replace(k=k, b=np.zeros(rods), alpha=0.0)
    omega = np.abs(natural_modes(model, np.zeros(rods))).min()
    assert omega == pytest.approx(math.sqrt(3 * EI / (L**3 * (M + 33 / 140 * m))), rel=2e-3)


@pytest.mark.parametrize("kappa", [1.0, 40.0, 100.0])
def test_less_inertia_makes_every_mode_faster_and_leaves_damping_ratios_and_statics(kappa: float) -> None:
    """Under gravity, with a tip load and damping of both kinds: eigenvalues grow by kappa^(1/2), angle and all."""
    actuator = changed(**LOADED, alpha=2.0)
    slow = observer_model(actuator, ControllerParameters())
    fast = observer_model(actuator, ControllerParameters(observer_kappa=kappa))
    u = np.array([0.02, -0.03])
    here = np.array(static_angles(build_statics(slow, actuator.u_max), *u))
    assert static_angles(build_statics(fast, actuator.u_max), *u) == pytest.approx(here, abs=1e-10)
    assert (fast.rest, fast.compliance) == (pytest.approx(slow.rest), pytest.approx(slow.compliance))
    assert natural_modes(fast, here) == pytest.approx(math.sqrt(kappa) * natural_modes(slow, here), rel=1e-6)
    if kappa == 1.0:  # the paper's, to the bit
        assert all(np.array_equal(getattr(fast, name), getattr(slow, name)) for name in ("m", "I", "g", "b", "alpha"))


def test_mass_follows_its_profile() -> None:
    model = build_rod(changed(mass_profile=(3.0, 1.0)), 20)
    assert model.m.sum() == pytest.approx(0.125)
    assert model.m[0] / model.m[-1] == pytest.approx(3.0)
    assert model.m[0] == pytest.approx(model.m[1])  # constant within a cell of the table


@pytest.mark.process
def test_a_loaded_bent_body_moves_as_in_mujoco() -> None:
    model = build_rod(changed(**LOADED), 10)._replace(alpha=0.0)
    state, load, chain = posed(model, np.zeros(10), np.zeros(10)), make_load(10), MujocoChain(model, 1e-3)
    for _ in range(1000):
        advance(model, state, load, 1e-3)
        chain.step()
        assert np.linalg.norm(chain.tip() - tip_of(model, state.q)) < 1e-6


@pytest.mark.parametrize("rods", [2, 10, 14])
def test_the_unactuated_body_comes_to_the_rest_that_is_computed(rods: int) -> None:
    model = build_rod(changed(**LOADED), rods)
    assert np.abs(model.rest).max() > 0.05
    state = advance(model, posed(model, np.zeros(rods), np.zeros(rods)), make_load(rods), 20.0, 2.5e-4)
    assert state.q == pytest.approx(at_rest(model).q, abs=1e-9)


def test_near_rest_the_static_map_holds_under_gravity() -> None:
    model, u, load = build_rod(changed(**LOADED), 10), np.array([2e-4, -1e-4]), make_load(10)
    load.Q_theta[:] = model.T_theta @ u
    state = advance(model, at_rest(model), load, 30.0)
    assert state.q[2] - model.rest == pytest.approx(model.compliance @ u, rel=2e-3)


def test_rest_curvature_bends_a_fine_body_to_an_arc() -> None:
    model = build_rod(changed(rest_curvature=(8.0,)), 1000)
    tip = tip_of(model, at_rest(model).q)
    assert tip == pytest.approx((math.sin(8 * 0.253) / 8, (1 - math.cos(8 * 0.253)) / 8), abs=1e-6)


def test_a_body_that_gravity_topples_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"gravity = \(-9.81, 0.0\) m/s\^2: the unactuated body has no"):
        build_rod(changed(gravity=(-9.81, 0.0)), 10)


@pytest.mark.parametrize(
    ("given", "slopes"),
    [((1e6, 3e6), (1e6, 1e6, 3e6, 3e6)), ((1e6, 1.2e6, 3e6, 2.5e6), (1e6, 1.2e6, 3e6, 2.5e6))],
    ids=["of pairs", "of chambers"],
)
def test_each_pair_or_chamber_has_its_own_pressure_map(given: tuple[float, ...], slopes: tuple[float, ...]) -> None:
    parameters = RigParameters(
        actuator=changed(pressure_map=given, u_max=0.05), controller=ControllerParameters(dead_time=0.0)
    )
    rig, twin = build_rig(parameters, 1), build_twin(parameters)
    assert rig.control.pascal_per_torque.tolist() == list(slopes)
    gain = twin.chambers.torque_per_pascal * rig.control.pascal_per_torque
    assert gain == pytest.approx(parameters.twin.kappa * np.repeat(parameters.twin.torque_gain, 2))


@pytest.mark.parametrize("plant", ["rod", "cosserat"])
def test_an_imbalance_gives_both_chambers_of_its_pair_another_gain_and_no_other_one(plant: PlantKind) -> None:
    own: dict[str, Any] = {"torque_gain": (1.1, 0.9), "chamber_imbalance": (0.0, 0.2)}
    given = {"cosserat": own} if plant == "cosserat" else own
    parameters = RigParameters(twin=TwinParameters.model_validate({"plant": plant, **given}))
    gain = build_plant(parameters).chambers.torque_per_pascal * parameters.actuator.chamber_slopes
    assert gain / parameters.twin.kappa == pytest.approx([1.1, 1.1, 0.9 * 1.2, 0.9 * 0.8])


def test_an_imbalance_of_0_changes_no_bit() -> None:
    gain = 1.136, 1.024
    assert chamber_gains(gain, (0.0, 0.0)).tobytes() == np.repeat(gain, 2).tobytes()
