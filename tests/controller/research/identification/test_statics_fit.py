"""Stiffness from poses that another computation made: the dynamic engine at rest, a dense solve, an energy minimum."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.errors import DataError
from controller.kernels.model.rod import RodModel, make_load
from controller.research.identification.poses import Poses, marker_arcs, predict, read_poses
from controller.research.identification.statics import fit_statics
from controller.research.identification.tables import read_measured
from controller.schema.actuator import PRESETS, Actuator, read_actuator, write_actuator
from tests.controller.chains import advance, posed
from tests.controller.coverage import P1, STRETCHED, UNEVEN, pressed
from tests.oracles import Chain

pytestmark = pytest.mark.keyed()

NOISE = 2e-4
ARCS = (0.126, 0.253)
TAPERED = PRESETS["P1"].model_copy(update={"k": (0.070, 0.030)})


def torques(count: int, seed: int = 0, limit: float = 0.045) -> Array:
    return np.random.default_rng(seed).uniform(-limit, limit, (count, 2))


def poses_of(angles: Array, model: RodModel, actuator: Actuator, u: Array, seed: int = 0) -> Poses:
    """Noisy markers at ARCS on chains with these angles (n,N)."""
    steps = model.L * np.stack([np.cos(angles), np.sin(angles)])
    joints = np.concatenate([np.zeros((2, len(u), 1)), np.cumsum(steps, axis=-1)], axis=-1)
    ends = np.concatenate([[0.0], np.cumsum(model.L)])
    points = np.array([[[np.interp(s, ends, joints[axis, n]) for axis in (0, 1)] for s in ARCS] for n in range(len(u))])
    points += np.random.default_rng(seed).normal(0.0, NOISE, points.shape)
    p = np.maximum(np.column_stack([u[:, 0], -u[:, 0], u[:, 1], -u[:, 1]]), 0.0) * actuator.chamber_slopes
    return Poses(Path("made.csv"), np.arange(2.0, len(u) + 2), p, False, points, np.array(ARCS))


def settled(actuator: Actuator, u: Array, rods: int = 14) -> Poses:
    """Poses where the dynamic engine comes to rest under constant torques."""
    model = build_rod(actuator, rods)._replace(alpha=8.0)
    angles = []
    for torque in u:
        load = make_load(rods)
        load.Q_theta[:] = model.T_theta @ torque
        angles.append(advance(model, posed(model, np.zeros(rods), np.zeros(rods)), load, 8.0, dt=5e-4).q[2])
    return poses_of(np.array(angles), model, actuator, u)


def solved(actuator: Actuator, u: Array, seed: int, rods: int = 40) -> Poses:
    """Poses of a dense linear solve."""
    model = build_rod(actuator, rods)
    angles = np.linalg.solve(Chain(model).hinges(model.k), model.T_theta @ u.T).T
    return poses_of(angles, model, actuator, u, seed)


def lowest_energy(actuator: Actuator, u: Array, rods: int = 20) -> Poses:
    """Poses of least potential energy: springs with a rest bend, gravity on rods and tip load, torques."""
    model = build_rod(actuator, rods)

    def energy(theta: Array, torque: Array) -> float:
        along = np.stack([np.cos(theta), np.sin(theta)])
        centres = np.cumsum(model.L * along, axis=1) - (model.L - model.arm) * along
        bends = np.diff(theta, prepend=0.0) - model.bend
        return float(0.5 * model.k @ bends**2 - model.m @ (model.g @ centres) - (model.T_theta @ torque) @ theta)

    angles = [minimize(energy, np.zeros(rods), args=(torque,), tol=1e-10).x for torque in u]
    return poses_of(np.array(angles), model, actuator, u)


@pytest.mark.parametrize("truth", [PRESETS["P3"].model_copy(update={"length": 0.253}), TAPERED])
def test_stiffness_and_taper_come_back_from_the_dynamic_engine_at_rest(truth: Actuator) -> None:
    base = PRESETS["P1"]
    fit = fit_statics(settled(truth, torques(16)), base, "linear" if len(truth.k) == 2 else "uniform")
    assert fit.actuator.k == pytest.approx(truth.k, rel=0.02)
    assert fit.misfits[-1].rms < 2 * 1e3 * NOISE


def test_stiffness_comes_back_under_gravity_tip_load_and_rest_curvature() -> None:
    hanging = {"gravity": (9.81, 0.0), "tip_load": 0.02, "rest_curvature": (0.8,)}
    base = PRESETS["P1"].model_copy(update=hanging)
    truth = base.model_copy(update={"k": (0.12,)})
    fit = fit_statics(lowest_energy(truth, torques(8)), base)
    assert fit.actuator.k == pytest.approx(truth.k, rel=0.02)
    assert fit.misfits[-1].rms < 2 * 1e3 * NOISE


def test_a_profile_of_many_joints_keeps_its_shape_and_is_scaled() -> None:
    base = PRESETS["P1"].model_copy(update={"k": tuple(np.linspace(0.08, 0.04, 10))})
    truth = base.model_copy(update={"k": tuple(1.3 * k for k in base.k)})
    fit = fit_statics(solved(truth, torques(12), seed=0), base)
    assert fit.actuator.k == pytest.approx(truth.k, rel=0.02)


def test_19_of_20_confidence_intervals_of_the_stiffness_hold_the_truth() -> None:
    fits = [fit_statics(solved(PRESETS["P1"], torques(8, seed), seed), PRESETS["P1"]) for seed in range(60)]
    inside = [fit.parameters[0].low <= 0.0751 <= fit.parameters[0].high for fit in fits]
    assert 0.87 <= np.mean(inside)


def test_one_wrong_marker_is_named_and_a_robust_fit_withstands_it() -> None:
    poses = solved(PRESETS["P1"], torques(16), seed=1)
    poses.points[3, 1] += (0.03, -0.02)
    plain, robust = fit_statics(poses, PRESETS["P1"]), fit_statics(poses, PRESETS["P1"], robust=True)
    assert "x2 in line 5" in plain.notes[0] and "--robust" in plain.notes[0]
    errors = [abs(fit.actuator.k[0] / 0.0751 - 1) for fit in (plain, robust)]
    assert errors[1] < 1e-3 < errors[0]
    assert robust.parameters[0].low <= 0.0751 <= robust.parameters[0].high


def test_four_chamber_pressures_are_taken_as_two_differences(tmp_path: Path) -> None:
    file = tmp_path / "poses.csv"
    file.write_text("p1_kpa,p2_kpa,p3_kpa,p4_kpa,x1_mm,y1_mm\n100,20,0,30,200,50\n0,0,0,0,253,0\n")
    poses = read_poses(read_measured(file), PRESETS["P1"])
    np.testing.assert_allclose(poses.pressure, [[80e3, -30e3], [0.0, 0.0]])
    assert poses.arcs == pytest.approx([0.253])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("p1,p2,x1,y1\n0,0,0.253,0\n", "every pressure is 0"),
        ("p1,x1,y1\n1,0.253,0\n", "column p2 is missing"),
        ("p1,p2,p4,x1,y1\n1,1,1,0.253,0\n", "column p3 is missing"),
        ("p1,p2,x1,y1,tip\n1,1,0.253,0,1\n", "column tip is unknown"),
        ("p1,p2,x1,y1\n1,1,253,0\n", r"line 2: marker 1 at \(253, 0\) m is farther from the base than"),
    ],
)
def test_a_table_that_is_no_static_test_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "poses.csv"
    file.write_text(text)
    with pytest.raises(DataError, match=complaint):
        read_poses(read_measured(file), PRESETS["P1"])


def test_poses_that_leave_an_unknown_free_are_refused() -> None:
    with pytest.raises(DataError, match="do not determine 2 unknowns"):
        fit_statics(poses_with_one_value(), PRESETS["P1"], "linear")


def poses_with_one_value() -> Poses:
    arcs = marker_arcs(PRESETS["P1"], 1)
    return Poses(
        Path("made.csv"),
        np.array([2.0]),
        np.array([[8e4, 0.0, 0.0, 0.0]]),
        False,
        np.array([[[0.2, 0.1]]]),
        arcs,
    )


def test_a_body_that_no_pressure_stiffens_and_no_arc_describes_better_keeps_its_table() -> None:
    u = torques(16)
    poses = solved(TAPERED, u, seed=3)
    held = np.random.default_rng(4).uniform(0.0, 1e5, u.shape)
    fit = fit_statics(
        replace(poses, chambers=poses.chambers + np.repeat(held, 2, axis=1), by_chamber=True), PRESETS["P1"], "linear"
    )
    assert fit.actuator.k == pytest.approx(TAPERED.k, rel=0.02)
    assert (fit.actuator.stiffening, fit.actuator.chamber_arcs, fit.actuator.EI) == ((0.0, 0.0), None, None)


def test_a_base_by_bending_stiffness_stays_one() -> None:
    truth = Actuator.model_validate(
        {"name": "rod", "mass": 0.1, "length": 0.25, "EI": (3e-3, 2e-3, 1e-3), "beta": 2e-3}
    )
    base = Actuator.model_validate(truth.model_dump(exclude={"k", "b"}) | {"EI": (1.5e-3, 1e-3, 0.5e-3)})
    fit = fit_statics(solved(truth, torques(12), seed=0), base)
    assert fit.actuator.EI == pytest.approx(truth.EI, rel=0.02)
    assert Actuator.model_validate(fit.actuator.model_dump()).k == pytest.approx(truth.k, rel=0.02)


def test_what_pressure_stretches_is_told_from_what_it_stiffens_and_the_file_can_be_written(tmp_path: Path) -> None:
    fit = fit_statics(pressed(STRETCHED, 12, 1), P1, "uniform")
    assert fit.actuator.stiffening == pytest.approx(STRETCHED.stiffening, rel=0.03)
    assert fit.actuator.stretching == pytest.approx(STRETCHED.stretching, rel=0.03)
    assert fit.actuator.pressure_map == P1.pressure_map
    write_actuator(fit.actuator, tmp_path / "mine.toml")
    assert read_actuator(tmp_path / "mine.toml").stretching == fit.actuator.stretching


def test_each_chamber_gets_its_gain_and_the_torque_limit_needs_the_pressure_that_it_needed(tmp_path: Path) -> None:
    fit = fit_statics(pressed(UNEVEN, 12, 1), P1, "uniform")
    found = fit.actuator
    assert found.pressure_map == pytest.approx(UNEVEN.pressure_map, rel=0.01)
    assert found.k == pytest.approx(P1.k, rel=0.01)
    assert found.u_max * max(found.pressure_map) == pytest.approx(P1.u_max * max(P1.pressure_map), rel=1e-6)
    write_actuator(found, tmp_path / "mine.toml")
    assert read_actuator(tmp_path / "mine.toml").pressure_map == found.pressure_map


def test_chambers_that_were_never_filled_get_no_gain() -> None:
    poses = pressed(UNEVEN, 12, 1)
    one_way = replace(poses, chambers=poses.chambers * [1.0, 0.0, 1.0, 0.0])
    fit = fit_statics(replace(one_way, points=predict(UNEVEN, one_way) + 1e-5), P1, "uniform")
    assert len(fit.actuator.pressure_map) == 2
