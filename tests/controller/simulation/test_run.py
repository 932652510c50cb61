"""Runs of a small reference, and of ones that cannot be run."""

import numpy as np
import pytest

from controller.assembly.statics import build_static_map, observer_model
from controller.errors import DataError, TendrilError
from controller.kernels.model.rod import RodModel
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.modes import Law, Mode
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, Settings, TwinParameters
from controller.simulation.metrics import Window, measure, true_tip
from controller.simulation.run import run
from tests.controller.statically import static_tip
from tests.controller.trial import Trial

PARAMETERS = RigParameters()
GOAL = (0.02, 0.02)
"""Torques of the goal [N m]."""


def hop(approach: int = 2000, hold: int = 1000) -> Reference:
    """From rest to a goal with a quintic blend in u, then a hold there."""
    smap = build_static_map(
        observer_model(PARAMETERS.actuator, PARAMETERS.controller), PARAMETERS.actuator, PARAMETERS.controller
    )
    s = np.clip(np.arange(approach + hold) / approach, 0.0, 1.0)
    share = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return Reference("hop", np.array([static_tip(smap.statics, GOAL[0] * a, GOAL[1] * a) for a in share]), approach)


@pytest.fixture(scope="module")
def reference() -> Reference:
    return hop()


def test_rows_are_aligned_to_the_reference_from_its_first_tick(reference: Reference) -> None:
    rows = run(PARAMETERS, reference, Settings(), seed=0)
    assert (rows["mode"] == Mode.TRACK).all()
    assert np.abs(rows["p_ref"] - reference.p).max() < 1e-4
    assert (np.diff(rows["tick"]) == 1).all()
    half = PARAMETERS.actuator.length / 2
    base, tip = (curvature * half for curvature in PARAMETERS.twin.set_curvature)
    lead = half * (1.5 * base + 0.5 * tip)  # the plant's set at rest, small angles
    assert np.linalg.norm(true_tip(rows)[0] - (reference.p[0] + (0.0, lead))) < 1e-3


def test_the_same_seed_gives_the_same_bits_and_another_seed_others(reference: Reference) -> None:
    first, again, other = (run(PARAMETERS, reference, Settings(), seed=seed) for seed in (3, 3, 4))
    assert first.tobytes() == again.tobytes()
    assert np.abs(true_tip(first) - true_tip(other)).max() > 1e-7


def test_what_a_law_leaves_of_a_static_error_is_what_its_loop_gain_says() -> None:
    """On a twin that bends more than the model, and does not stick: all of it, 1 / (1 + K_P) of it, nothing."""
    smooth = TwinParameters(
        torque_gain=(1.1, 1.1), friction=0.0, hysteresis=0.0, set_curvature=(0.0, 0.0), creep=(0.05, 0.05)
    )
    parameters, long = PARAMETERS.model_copy(update={"twin": smooth}), hop(hold=8000)
    last = Reference("hold", long.p, start=len(long.p) - 100)
    FF, FF_P, FF_PI = (
        measure(run(parameters, long, Settings(law=law, K_P=(0.3, 0.3)), 0), last, Window.AFTER_APPROACH)
        for law in (Law.FF, Law.FF_P, Law.FF_PI)
    )
    assert FF_P["rmse"] / FF["rmse"] == pytest.approx(1.0 / 1.3, rel=0.05)
    assert FF_PI["rmse"] < 0.05 * FF["rmse"]
    assert FF["feedback_share"] == 0.0 < FF_P["feedback_share"] < FF_PI["feedback_share"]


def test_only_the_wanted_sensors_are_used(reference: Reference) -> None:
    rows = run(PARAMETERS, reference, Settings(sensed=1 << 5), seed=0)
    assert (rows["sensed"] == 1 << 5).all()


def test_the_velocity_gain_counts_where_the_reference_has_it_on_and_not_in_the_approach(reference: Reference) -> None:
    """The same motion as an approach, and as a shape that begins at 0.5 s."""
    approached = Reference("approached", reference.p, reference.start, velocity_feedforward=True)
    fast = Reference("fast", reference.p, 500, velocity_feedforward=True)
    gain = Settings(K_FF=(0.1, 0.1))
    plain, off = run(PARAMETERS, reference, Settings(), 0), run(PARAMETERS, reference, gain, 0)
    led, on = run(PARAMETERS, approached, gain, 0), run(PARAMETERS, fast, gain, 0)
    assert (plain["u"] == off["u"]).all() and (led["u"][:1999] == off["u"][:1999]).all()
    assert (on["u"][:499] == off["u"][:499]).all() and np.abs(on["u"] - off["u"])[499:2000].max() > 1e-4


def test_a_run_that_ends_in_a_fault_is_an_error_with_its_cause(reference: Reference) -> None:
    impatient = PARAMETERS.model_copy(update={"limits": SafetyLimits(error_max=1e-4, error_time=0.1)})
    with pytest.raises(TendrilError, match=r"hop: FAULT \(TRACKING_ERROR\) after \d"):
        run(impatient, reference, Settings(), seed=0)


def test_what_cannot_be_planned_is_refused_with_its_reason(reference: Reference) -> None:
    slow = PARAMETERS.model_copy(update={"controller": ControllerParameters(dt=5e-4)})
    with pytest.raises(DataError, match=r"the tick is 0\.0005 s"):
        run(slow, reference, Settings(), seed=0)
    with pytest.raises(DataError, match="0 rows of reference"):
        run(PARAMETERS, Reference("none", np.zeros((0, 2)), 0), Settings(), seed=0)
    with pytest.raises(DataError, match="not finite"):
        run(PARAMETERS, Reference("hole", np.full((5, 2), np.nan), 0), Settings(), seed=0)


def test_a_run_leaves_the_chain_that_rigs_of_one_actuator_share_as_it_was() -> None:
    actuator = PRESETS["P1"].model_copy(update={"stiffening": (2e-6, 1e-6)})
    parameters = RigParameters(actuator=actuator)
    shared = observer_model(actuator, parameters.controller)
    names = list(RodModel.__annotations__)
    before = [np.array(getattr(shared, name)) for name in names]
    trial = Trial(parameters=parameters)
    trial.arm()
    rows = trial.follow(0.15, 0.1, 1.0)
    assert (rows["mode"] == Mode.FOLLOW).all() and np.abs(rows["u"]).max() > 0.01
    assert observer_model(actuator, parameters.controller) is shared
    for name, was in zip(names, before, strict=True):
        np.testing.assert_array_equal(getattr(shared, name), was)
