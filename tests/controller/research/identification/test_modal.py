import math

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes, point_slopes
from controller.errors import DataError
from controller.kernels.model.statics import places
from controller.research.identification.fit import Estimate, Fit
from controller.research.identification.motion import modal_solve
from controller.research.identification.motion.decays import Decay
from controller.research.identification.motion.directions import is_directional
from controller.research.identification.motion.hold import held_pose, positions, torques_to
from controller.research.identification.motion.modal import first_mode, stiffness_scale, tapered
from controller.research.identification.motion.modal_fit import _load_note, fit_modes
from controller.research.identification.motion.modal_solve import LIMIT, SPREAD, START, Found, at_limit
from controller.research.identification.offline import in_plane
from controller.schema.actuator import Actuator
from tests.controller.decaying import ARCS, decays_of, hanging_body

pytestmark = pytest.mark.keyed()

TORQUES = np.array(
    [[0, 0, 0.5], [0, 0.4, 0], [0.5, 0, 0], [0.1, -0.3, 0.5], [0, 0.3, 0.2], [0, 0, -0.4], [0.2, 0.2, 0],
     [0.3, 0, 0.2], [0, -0.3, -0.1], [-0.2, 0, 0.4]]
)  # fmt: skip
BOTH_WAYS = np.vstack([TORQUES, -1.1 * TORQUES])


@pytest.fixture(scope="module", params=[pytest.param(1, marks=pytest.mark.long), 2])
def decays(request: pytest.FixtureRequest) -> list[Decay]:
    return decays_of(hanging_body(), BOTH_WAYS, seed=request.param)


@pytest.fixture(scope="module")
def fit(decays: list[Decay]) -> Fit:
    base = hanging_body().model_copy(update={"k": (1.0,), "b": (0.0,), "alpha": 0.0, "tracking": None})
    return fit_modes(decays, base)


def estimate_of(fit: Fit, name: str) -> Estimate:
    return next(one for one in fit.parameters if one.name.startswith(name))


def test_frequency_damping_and_taper_come_back_from_noisy_decays_of_a_finer_body(fit: Fit) -> None:
    truth = hanging_body()
    model = build_rod(truth, 40)
    first = min(natural_modes(model, model.rest), key=abs)
    assert estimate_of(fit, "frequency").value == pytest.approx(abs(first) / math.tau, rel=0.02)
    assert estimate_of(fit, "zeta").value == pytest.approx(-first.real / abs(first), rel=0.02)
    assert estimate_of(fit, "taper").value == pytest.approx(truth.k[1] / truth.k[0], rel=0.02)
    assert fit.actuator.k == pytest.approx(truth.k, rel=0.02)


def test_the_written_body_swings_with_the_measured_frequency_and_damping(fit: Fit) -> None:
    model = build_rod(fit.actuator, 40)
    first = min(natural_modes(model, model.rest), key=abs)
    assert abs(first) / math.tau == pytest.approx(estimate_of(fit, "frequency").value, rel=0.002)
    assert -first.real / abs(first) == pytest.approx(estimate_of(fit, "zeta").value, rel=0.002)


def test_the_confidence_interval_of_the_taper_contains_the_truth_and_is_narrow(fit: Fit) -> None:
    taper = estimate_of(fit, "taper")
    assert taper.low < 0.4 < taper.high
    assert taper.high - taper.low < 0.05


def test_tracked_bodies_and_their_inner_motion_are_found_within_a_few_times_the_noise(fit: Fit) -> None:
    assert fit.actuator.tracking is not None
    assert fit.actuator.tracking.arcs == pytest.approx(ARCS, abs=2e-4)
    assert max(one.rms for one in fit.misfits if not one.name.endswith("sensed")) < 3.0 * 0.2


def test_the_stiffness_scale_gives_the_chain_the_frequency_asked_for() -> None:
    found = tapered(hanging_body(), 15.0, -0.7)
    model = build_rod(found, 40)._replace(b=np.zeros(40), alpha=0.0)
    assert np.abs(natural_modes(model, model.rest)).min() == pytest.approx(15.0, rel=1e-6)
    assert stiffness_scale(model, 15.0) == pytest.approx(1.0, rel=1e-6)
    assert found.k[1] / found.k[0] == pytest.approx(math.exp(-0.7))


def test_a_mode_slower_than_the_pendulum_is_refused() -> None:
    with pytest.raises(DataError, match="gravity alone makes"):
        tapered(hanging_body(), 2.0, 0.0)


def test_the_first_mode_of_a_massless_uniform_body_is_a_loaded_cantilevers_curve() -> None:
    # The table's base joint counts a whole cell: half a cell, L/20, bends under the clamp's moment before x = 0.
    light = hanging_body().model_copy(update={"mass": 1e-6, "gravity": (0.0, 0.0), "k": (1.0,)})
    s = np.array(ARCS[:-1]) / ARCS[-1]
    curve = s**2 / 2 - s**3 / 6 + s / 20
    assert first_mode(light, ARCS) == pytest.approx(curve / (1 / 2 - 1 / 6 + 1 / 20), rel=1e-3)


def test_the_held_pose_meets_what_is_seen_and_is_in_balance() -> None:
    model = build_rod(hanging_body(), 10)
    T, last = torques_to(model, np.array(ARCS)), places(model, np.array(ARCS[-1:]))
    moved = np.array([[-0.02, 0.07]])
    theta, held = held_pose(model, T, last, moved, np.array([5.0, 5.0, 5.0]))
    assert positions(model, theta, last) - positions(model, model.rest, last) == pytest.approx(moved, abs=1e-3)
    beyond = np.cumsum(model.m[::-1])[::-1] - model.m
    spring = model.k * np.diff(theta, prepend=0.0)
    weight = 9.81 * (model.L * beyond + model.m * model.arm) * np.sin(theta)
    assert held == pytest.approx(spring - np.append(spring[1:], 0.0) + weight, abs=1e-9)


def test_slopes_are_the_derivatives_of_the_points() -> None:
    model, theta = build_rod(hanging_body(), 10), np.linspace(0.1, 0.9, 10)
    at = places(model, np.array(ARCS))
    step = 1e-6 * np.eye(10)
    numeric = [(positions(model, theta + d, at) - positions(model, theta - d, at)).ravel() / 2e-6 for d in step]
    assert point_slopes(model, theta, at) == pytest.approx(np.array(numeric).T, abs=1e-8)


def test_a_tip_load_at_the_end_of_its_range_is_said() -> None:
    heavy = START._replace(load=START.load + LIMIT * SPREAD.load)
    assert at_limit(heavy, "load") and not at_limit(START, "load")
    found = Found(heavy, np.eye(7), 2.0, settled=True, cost=0.0)
    bare = hanging_body().model_copy(update={"tip_load": 0.0})
    assert "give the base actuator its tip_load" in _load_note(found, bare)[0]
    assert _load_note(found, hanging_body()) == ()


def test_one_body_is_refused(decays: list[Decay]) -> None:
    alone = [Decay(one.id, one.t, one.points[:, -1:]) for one in decays]
    with pytest.raises(DataError, match="needs at least 2"):
        fit_modes(alone, hanging_body())


def test_a_search_that_gives_up_is_reported(decays: list[Decay], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(modal_solve, "EVALUATIONS", 2)
    assert any("did not settle" in note for note in fit_modes(decays[:3], hanging_body()).notes)


@pytest.fixture(scope="module")
def directional() -> Actuator:
    """Stiffer at the base for bending along one of two directions at right angles, at 25 degrees in the file."""
    body = hanging_body()
    assert body.tracking is not None
    principal = (math.cos(math.radians(25)), 0.0, math.sin(math.radians(25)))
    tracking = body.tracking.model_copy(update={"principal": principal, "k_across": (10.0, 10.0)})
    return body.model_copy(update={"tracking": tracking})


def test_a_body_that_bends_otherwise_in_another_direction_is_told_from_one_that_does_not(
    directional: Actuator, fit: Fit
) -> None:
    found = fit_modes(decays_of(directional, TORQUES), hanging_body().model_copy(update={"tracking": None})).actuator
    assert found.tracking is not None and found.tracking.k_across is not None
    assert fit.actuator.tracking is not None and fit.actuator.tracking.k_across is None
    for degrees in (0, 25, 70, 115, 160):
        way = np.array([math.cos(math.radians(degrees)), 0.0, math.sin(math.radians(degrees))])
        expected = first_mode(in_plane(directional, way), ARCS)
        assert first_mode(in_plane(found, way), ARCS) == pytest.approx(expected, abs=0.01)


def test_bending_stiffness_turns_with_the_direction_as_a_tensor_does(directional: Actuator) -> None:
    assert directional.tracking is not None
    along = np.array(directional.tracking.principal)
    across = np.array([-along[2], 0.0, along[0]])
    between = (along + across) / math.sqrt(2)
    assert in_plane(directional, along).k == pytest.approx(directional.k)
    assert in_plane(directional, -across).k == pytest.approx(directional.tracking.k_across)
    mean = (np.array(directional.k) + directional.tracking.k_across) / 2
    flat = in_plane(directional, between)
    assert flat.k == pytest.approx(mean)
    assert np.divide(flat.b, flat.k) == pytest.approx(np.divide(directional.b, directional.k))


def test_a_decay_that_no_other_decay_predicts_says_nothing_of_directions() -> None:
    random, angles = np.random.default_rng(3), np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 1.6])
    ways = np.stack([np.cos(angles), np.zeros(7), np.sin(angles)], axis=1)
    ratios = 0.3 + 0.1 * np.cos(2 * angles)[:, None] + random.normal(0, 1e-3, (7, 1))
    assert not is_directional(ratios, ways, np.array([0.0, -1.0, 0.0]))
    spread = np.linspace(0.0, 3.0, 7)
    ways = np.stack([np.cos(spread), np.zeros(7), np.sin(spread)], axis=1)
    assert is_directional(0.3 + 0.1 * np.cos(2 * spread)[:, None], ways, np.array([0.0, -1.0, 0.0]))
