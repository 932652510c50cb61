"""The paper's measures on signals whose answers are known on paper."""

import math

import numpy as np
import pytest

from controller.arrays import Rows
from controller.errors import DataError
from controller.reference.reference import Reference
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.simulation import metrics
from controller.simulation.metrics import Window, measure

TIME = np.arange(3000) * 1e-3


def run_with_error(reference: Reference, e: np.ndarray, observer: float = 0.0) -> Rows:
    """Telemetry of a tip that is e (n,2) [m] short of the reference, and an observer this far off along x."""
    rows = np.zeros(len(e), record_dtype(Telemetry))
    rows["twin_backbone"][:, -1] = reference.p - e
    rows["p_hat"] = reference.p - e + [observer, 0.0]
    rows["p_meas"] = np.nan
    return rows


def circle(frequency: float, late_deg: float) -> np.ndarray:
    angle = 2.0 * math.pi * frequency * TIME - math.radians(late_deg)
    return 0.03 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [0.03, 0.14]


def test_rmse_is_the_length_of_a_constant_error_in_the_plane() -> None:
    assert metrics.rmse(np.tile([3e-3, 4e-3], (100, 1))) == pytest.approx(5e-3)


def test_the_errors_of_a_decaying_step_are_those_of_the_integral() -> None:
    """With e = e_0 exp(-t / tau), ISE = e_0^2 tau / 2, RMSE = sqrt(ISE / T); the sum over ticks adds dt / tau of it."""
    e = np.zeros((3000, 2))
    e[:, 1] = 0.06 * np.exp(-TIME / 0.2)
    exact = 0.06**2 * 0.2 / 2 * (1.0 + 1e-3 / 0.2)
    assert metrics.ise(e) == pytest.approx(exact, rel=1e-4)
    assert metrics.rmse(e) == pytest.approx(math.sqrt(exact / 3.0), rel=1e-4)


def test_the_steady_state_error_is_that_of_the_last_tenth() -> None:
    e = np.zeros((3000, 2))
    e[:2700] = 1.0
    e[2700:, 0] = np.linspace(-1e-3, 1e-3, 300)
    assert metrics.sse(e) == pytest.approx(0.5e-3, rel=1e-2)


@pytest.mark.parametrize("late", [-100.0, 0.0, 27.0, 179.0])
@pytest.mark.parametrize("frequency", [1.0, 2.0, 1.3])
def test_the_lag_is_the_angle_by_which_a_sine_comes_late(frequency: float, late: float) -> None:
    p_ref, p = circle(frequency, 0.0), 0.7 * circle(frequency, late)
    for axis in range(2):
        assert metrics.lag_deg(p_ref[:, axis], p[:, axis], frequency) == pytest.approx(late, abs=1e-6)


def test_a_delay_is_a_lag_of_its_share_of_a_period() -> None:
    p = circle(2.0, 0.0)[:, 1]
    assert metrics.lag_deg(p[50:], p[:-50], 2.0) == pytest.approx(36.0, abs=1e-6)


def test_the_lag_hears_neither_noise_nor_another_frequency() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1e-3, 3000)
    p = circle(1.0, 27.0)[:, 0] + 0.01 * np.sin(2 * math.pi * 3.0 * TIME) + noise
    assert metrics.lag_deg(circle(1.0, 0.0)[:, 0], p, 1.0) == pytest.approx(27.0, abs=0.3)


def test_what_does_not_swing_or_not_long_enough_has_no_phase() -> None:
    p = circle(1.0, 0.0)[:, 0]
    assert math.isnan(metrics.lag_deg(np.full(3000, 0.03), p, 1.0))
    assert math.isnan(metrics.lag_deg(p, np.full(3000, 0.03), 1.0))
    assert math.isnan(metrics.lag_deg(p[:900], p[:900], 1.0))


def test_the_share_of_feedback_runs_from_nothing_to_all() -> None:
    u = np.tile([3e-3, -4e-3], (10, 1))
    assert metrics.feedback_share(u, 0.0 * u) == 0.0
    assert metrics.feedback_share(0.0 * u, u) == 1.0
    assert metrics.feedback_share(u, u[:, ::-1] / 3.0) == pytest.approx(0.25)
    assert metrics.feedback_share(0.0 * u, 0.0 * u) == 0.0


def test_the_two_windows_differ_by_the_approach() -> None:
    reference = Reference("vu", np.tile([0.0, 0.14], (3000, 1)), start=2000)
    e = np.zeros((3000, 2))
    e[:2000, 0], e[2000:, 1] = -6e-3, 3e-3
    rows = run_with_error(reference, e)
    whole, after = (measure(rows, reference, window) for window in (Window.WHOLE, Window.AFTER_APPROACH))
    assert whole["rmse"] == pytest.approx(math.sqrt((2 * 36 + 9) / 3), rel=1e-4)
    assert after["rmse"] == pytest.approx(3.0, rel=1e-4)
    assert whole["ise"] == pytest.approx(2 * 36 + 9, rel=1e-4)
    assert (whole["max_x"], whole["max_y"]) == pytest.approx((6.0, 3.0), rel=1e-4)
    assert (after["max_x"], after["max_y"]) == pytest.approx((0.0, 3.0), abs=1e-3)
    assert not {"sse", "lag_deg_x", "lag_deg_y"} & (set(whole) | set(after))


def test_errors_of_steps_are_averaged_over_the_steps() -> None:
    """Constant errors of 1, 2, 3 and 4 mm over four steps of 0.5 s."""
    reference = Reference("step", np.zeros((3000, 2)), start=1000, steps=(1000, 1500, 2000, 2500))
    e = np.full((3000, 2), 0.05)
    for i, begin in enumerate(reference.steps):
        e[begin : begin + 500] = 0.0, 1e-3 * (i + 1)
    found = measure(run_with_error(reference, e), reference, Window.AFTER_APPROACH)
    assert found["rmse"] == pytest.approx(2.5, rel=1e-4)
    assert found["sse"] == pytest.approx(2.5, rel=1e-4)
    assert found["ise"] == pytest.approx(0.5 * (1 + 4 + 9 + 16) / 4, rel=1e-4)


def test_the_observer_is_judged_by_the_true_tip() -> None:
    reference = Reference("vu", np.zeros((100, 2)), start=0)
    rows = run_with_error(reference, np.full((100, 2), 0.01), observer=2.2e-3)
    assert measure(rows, reference, Window.WHOLE)["observer_rmse"] == pytest.approx(2.2, rel=1e-3)


def test_hardware_is_judged_by_its_marker_and_its_observer_is_not() -> None:
    reference = Reference("vu", np.zeros((100, 2)), start=0)
    rows = run_with_error(reference, np.zeros((100, 2)))
    rows["twin_backbone"], rows["p_meas"] = np.nan, [3e-3, 4e-3]
    found = measure(rows, reference, Window.WHOLE)
    assert found["rmse"] == pytest.approx(5.0)
    assert "observer_rmse" not in found


def test_a_straight_line_has_a_lag_along_itself_only() -> None:
    p = circle(1.0, 0.0) * [0.0, 1.0]
    reference = Reference("vertical_1hz", p, start=0, frequency=1.0)
    found = measure(run_with_error(reference, p - circle(1.0, 10.0)), reference, Window.WHOLE)
    assert found["lag_deg_y"] == pytest.approx(10.0, abs=1e-3)
    assert "lag_deg_x" not in found


def test_rows_of_another_length_are_refused() -> None:
    reference = Reference("vu", np.zeros((100, 2)), start=0)
    with pytest.raises(DataError, match="99 rows of telemetry for 100"):
        measure(np.zeros(99, record_dtype(Telemetry)), reference, Window.WHOLE)
