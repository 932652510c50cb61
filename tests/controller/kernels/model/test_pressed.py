"""A body that pressure stiffens and stretches: statics, observer and plants, against energies written out here."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import minimize

from controller.arrays import Array
from controller.assembly.rig import build_rig
from controller.assembly.rod import bend_edges, build_rod, chamber_ends, covered
from controller.assembly.statics import build_static_map, build_statics, static_map
from controller.assembly.twin import build_twin
from controller.kernels.control.inverse import TOLERANCE
from controller.kernels.model.equilibrium import make_scratch, out_of_balance
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import is_linear, points_on, tip_of
from controller.kernels.observer.observer import (
    Observer,
    advance_pneumatics,
    believe_torques,
    pressurise,
    step_observer,
)
from controller.kernels.plant.twin import twin_step
from controller.realtime.compiled import compiled
from controller.reference.feasible.reach import static_tips
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.layout import record_dtype
from controller.schema.messages import Measurement, Telemetry
from controller.schema.modes import Integrator, Mode
from controller.schema.parameters import ControllerParameters, RigParameters, TwinParameters
from tests.controller.statically import invert, require_slopes, static_angles, static_tip

pytestmark = pytest.mark.keyed()

U_MAX = 0.06
STIFF = (1.6e-6, 2.4e-6)
"""Half and three quarters more at u_max [1/Pa]."""
LONG = (2e-7, 3e-7)
"""5 and 7 % longer at u_max [1/Pa]."""
MADE = {
    "stiffer": {"stiffening": STIFF},
    "longer": {"stretching": LONG},
    "both": {"stiffening": STIFF, "stretching": LONG},
}
"""What pressure makes the body."""
SLOPES = (3.6e6, 4.02e6, 4.4e6, 3.9e6)
"""Of chambers that are not alike [Pa/(N m)]."""
CALLS = 12
"""Of the inverse, until it has settled."""
LOADS: dict[str, dict[str, Any]] = {
    "on a sheet": {},
    "bent at rest": {"rest_curvature": (2.0, -1.0)},
    "hanging": {"gravity": (9.81, 0.0), "tip_load": 0.03, "rest_curvature": (2.0, -1.0)},
    "lying": {"gravity": (0.0, -4.0)},
}


def actuator(name: str = "P1", made: str = "stiffer", **changes: Any) -> Actuator:
    return Actuator.model_validate(PRESETS[name].model_dump() | MADE[made] | changes)


def grown(own: Array, shares: tuple[float, float], body: Actuator, u: Array) -> Array:
    """What of each hinge or rod (N,) its pair's pressure makes, from the file's numbers and where its pairs reach."""
    inner = np.arange(own.size) < own.size // 2
    more = np.array(shares) * np.abs(u) * body.pair_slopes
    return np.asarray(own * (1.0 + np.where(inner, *more)))


def lowest(body: Actuator, model: RodModel, u: Array, start: Array) -> Array:
    """The minimum of energy nearest to `start`, by a quasi-Newton method with numerical slopes."""
    k, scale = grown(model.k, body.stiffening, body, u), 1.0 / model.k.mean()
    L, arm = (grown(own, body.stretching, body, u) for own in (model.L, model.arm))

    def energy(theta: Array) -> float:
        along = np.array([np.cos(theta), np.sin(theta)])
        centres = np.cumsum(L * along, axis=1) - (L - arm) * along
        turns = np.diff(theta, prepend=0.0) - model.bend
        return scale * float(0.5 * k @ turns**2 - model.m @ (model.g @ centres) - theta @ model.T_theta @ u)

    return np.asarray(minimize(energy, start, method="BFGS", options={"gtol": 1e-9}).x)


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("name", PRESETS)
def test_the_static_pose_is_the_least_energy_of_a_body_as_stiff_and_long_as_its_pressures(
    name: str, load: str, made: str
) -> None:
    body = actuator(name, made, **LOADS[load])
    model, scratch = build_rod(body, 10), make_scratch(10)
    statics = build_statics(model, U_MAX)
    assert is_linear(statics) == (made == "longer" and "gravity" not in LOADS[load])
    for u in np.random.default_rng(1).uniform(-U_MAX, U_MAX, (4, 2)):
        theta = static_angles(statics, *u)
        L = grown(model.L, body.stretching, body, u)
        assert static_tip(statics, *u) == pytest.approx([L @ np.cos(theta), L @ np.sin(theta)], abs=1e-12)
        assert theta == pytest.approx(lowest(body, model, u, theta + 0.01), abs=2e-5)
        scratch.theta[:] = theta
        assert out_of_balance(statics.body, *u, scratch) < 1e-9


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("load", LOADS)
def test_sensitivity_and_curvature_are_differences_of_the_tip(load: str, made: str) -> None:
    statics = build_statics(build_rod(actuator("P2", made, **LOADS[load]), 10), U_MAX)
    for u in np.random.default_rng(3).uniform(-U_MAX, U_MAX, (6, 2)):
        require_slopes(statics, u)


@pytest.mark.parametrize("load", ["on a sheet", "bent at rest"])
@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("made", ["stiffer", "both"])
def test_every_point_within_reach_is_found_from_anywhere(made: str, name: str, load: str) -> None:
    smap = static_map(actuator(name, made, **LOADS[load]), ControllerParameters())
    random, now = np.random.default_rng(5), (0.0, 0.0)
    somewhere = smap.seeds[random.integers(len(smap.seeds), size=600)] * random.uniform(0.5, 1.0, (600, 1))
    missed = []
    for goal in static_tips(smap, somewhere):
        for _ in range(CALLS):
            *now, distance = invert(smap, (goal[0], goal[1]), (now[0], now[1]), True)
        if distance > TOLERANCE:
            missed.append((goal, distance))
    assert not missed


def test_no_pose_within_the_admissible_torques_bends_beyond_the_limit() -> None:
    body = actuator("P1", bend_max=3.0)
    smap = build_static_map(build_rod(body, 10), body, ControllerParameters())
    bends = [abs(static_angles(smap.statics, *u)[-1]) for u in smap.seeds]
    assert 2.5 < max(bends) <= 3.0


@compiled
def run(observer: Observer, u_1: float, u_2: float, ticks: int, excess: Array) -> None:
    """Let the observer go on under u; the most by which its energy exceeds what it was given."""
    for _ in range(ticks):
        advance_pneumatics(u_1, u_2, observer)
        believe_torques(observer)
        pressurise(observer)
        step_observer(observer)
        excess[0] = max(excess[0], observer.ledger.energy[0] - observer.ledger.given[0])


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("load", ["on a sheet", "hanging"])
@pytest.mark.parametrize("integrator", Integrator)
def test_the_observer_rests_where_the_static_map_says_and_its_ledger_holds_on_the_way(
    integrator: Integrator, load: str, made: str
) -> None:
    controller = ControllerParameters(integrator=integrator)
    rig = build_rig(RigParameters(actuator=actuator("P1", made, **LOADS[load]), controller=controller), 1)
    excess = np.full(1, -1.0)
    for u in [(0.05, -0.03), (-0.04, -0.02), (0.03, 0.05)]:
        run(rig.observer, *u, 6000, excess)
        expected = static_angles(rig.control.smap.statics, *u)
        assert rig.observer.state.q[2] == pytest.approx(expected, abs=1e-4)
        tip = static_tip(rig.control.smap.statics, *u)
        assert tip_of(rig.observer.model, rig.observer.state.q) == pytest.approx(tip, abs=1e-4)
        points_on(rig.observer.state.q, rig.observer.sensors, rig.observer.points)
        assert rig.observer.points[-1] == pytest.approx(tip, abs=1e-4)
    assert excess[0] < (1e-9 if integrator == Integrator.IMPLICIT else 2e-6)


@pytest.mark.parametrize("made", MADE)
@pytest.mark.parametrize("integrator", Integrator)
def test_the_twin_of_such_an_actuator_rests_where_its_static_map_says(integrator: Integrator, made: str) -> None:
    twin = TwinParameters(
        rods=10,
        integrator=integrator,
        friction=0.0,
        hysteresis=0.0,
        creep=(0.0, 0.0),
        set_curvature=(0.0, 0.0),
        torque_gain=(1.0, 1.0),
        stiffness_scale=1.0,
        marker_noise=0.0,
    )
    body, u = actuator(made=made, pressure_map=SLOPES, u_max=0.05), np.array([0.04, -0.03])
    parameters = RigParameters(actuator=body, twin=twin)
    plant = build_twin(parameters)
    rows, seen = np.zeros(1, record_dtype(Telemetry)), np.zeros(1, record_dtype(Measurement))
    rows["mode"] = Mode.HOLD
    rows["pressure_cmd"][0] = np.array([u[0], 0.0, 0.0, -u[1]]) * SLOPES
    for tick in range(8000):
        twin_step(1_000_000 * tick, plant, rows[0], seen[0])
    statics = build_statics(build_rod(body, 10), U_MAX)
    assert plant.state.q[2] == pytest.approx(static_angles(statics, *u), abs=5e-3)
    tip = static_tip(statics, *u)
    assert rows["twin_backbone"][0, -1] == pytest.approx(tip, abs=5e-4)
    assert plant.camera.points[0, -1] == pytest.approx(tip, abs=5e-4)


@pytest.mark.parametrize("rods", [10, 20, 33])
def test_chambers_by_arc_give_each_hinge_the_share_of_them_that_its_part_of_the_backbone_has(rods: int) -> None:
    length = PRESETS["P1"].length
    arcs = ((0.0, 0.4 * length), (0.43 * length, length))
    body = actuator(chamber_arcs=arcs)
    edges = bend_edges(rods)
    moments = np.cumsum(build_rod(body, rods).T_theta[::-1], axis=0)[::-1]
    assert moments == pytest.approx(np.column_stack([covered(edges, *ends) for ends in chamber_ends(body)]))


def test_chambers_by_arc_at_the_middles_of_rods_are_those_of_the_table() -> None:
    length = PRESETS["P1"].length
    body = actuator(chamber_arcs=((0.0, 0.45 * length), (0.45 * length, 0.95 * length)))
    for rods in (5, 10, 17):
        assert build_rod(body, rods).T_theta == pytest.approx(build_rod(PRESETS["P1"], rods).T_theta)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffening": (-1e-6, 0.0)}, "stiffening.*greater than or equal to 0"),
        ({"stiffening": (1e-6, 1e-4)}, r"stiffening of pair 2 = 0.0001 /Pa is above 4.14e-05 /Pa"),
        ({"stretching": (1e-6, 2e-6)}, r"stretching of pair 2 = 2e-06 /Pa is above 1.04e-06 /Pa, .* lengthen by 50%"),
        ({"pressure_map": (4e6, 4e6, 4.1e6, 4e6)}, "u_max = 0.06 N m needs 246000 Pa, above pressure_max"),
        ({"pressure_map": (4e6, 4e6, 4.1e6)}, "pressure_map"),
        (
            {"chamber_arcs": ((0.0, 0.1), (0.1, 0.3))},
            r"chamber_arcs \(0.1 m, 0.3 m\): .* length = 0.253 m",
        ),
        ({"chamber_arcs": ((0.1, 0.1), (0.1, 0.2))}, r"chamber_arcs \(0.1 m, 0.1 m\): first < second"),
    ],
)
def test_what_no_actuator_can_have_is_refused_by_field_value_and_bound(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=f"(?s){message}"):
        actuator(**changes)
