"""A marker that is followed live: what is read, when it is looked at, and what the error is taken against."""

from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError, TendrilError
from controller.schema.modes import Mode
from controller.schema.parameters import Settings, TwinParameters
from controller.simulation.case import Case, Outcome, Setup
from controller.simulation.live_path import LIVE_PATH_FILE, MarkerPath, live_settings, read_marker_path, run_live
from controller.simulation.metrics import Window

CASE = Case("live_path")


def drawn(seconds: float = 2.0, rate: float = 60.0, y: float = 0.14) -> MarkerPath:
    """A slow curve through P1's reach, that begins in it, at the times of a screen."""
    t = 5.0 + np.arange(round(seconds * rate) + 1) / rate
    return MarkerPath(t, np.stack([30e-3 + 40e-3 * np.sin(t - 5.0), np.full(len(t), y)], axis=1))


@pytest.fixture(scope="module")
def followed() -> Outcome:
    return run_live(CASE, Setup(), drawn())


def test_a_path_that_can_be_reached_is_its_own_reference_held_between_samples(followed: Outcome) -> None:
    marker, p = drawn(), followed.reference.p
    assert len(p) == len(followed.rows) == 2000
    assert np.abs(p - marker.at(np.repeat(np.arange(200) * 0.01, 10))).max() < 1e-12
    assert (followed.rows["mode"] == Mode.FOLLOW).all()


def test_the_tick_looks_at_the_marker_a_hundred_times_a_second(followed: Outcome) -> None:
    changes = np.flatnonzero((np.diff(followed.rows["target"], axis=0) != 0.0).any(axis=1)) + 1
    assert len(changes) > 90
    assert set(changes % 10) == {0}
    assert set(followed.rows["tick"][changes] % 10) == {0}


def test_the_tip_is_at_the_first_point_before_the_path_begins(followed: Outcome) -> None:
    assert np.linalg.norm(followed.rows["p_ref"][0] - drawn().p[0]) < 1e-3
    assert followed.reference.start == 0
    assert followed.metrics[Window.WHOLE] == followed.metrics[Window.AFTER_APPROACH]


def test_a_marker_out_of_reach_is_projected_and_the_error_is_taken_from_there() -> None:
    far = run_live(CASE, Setup(), drawn(y=0.30))
    marker = drawn(y=0.30)
    off = np.linalg.norm(far.reference.p - marker.at(np.arange(2000) * 1e-3), axis=1)
    assert off.min() > 30e-3
    assert np.linalg.norm(far.reference.p - far.rows["p_ref"], axis=1).max() < 5e-3
    assert far.metrics[Window.WHOLE]["rmse"] * 1e-3 < off.min()


def test_the_same_path_gives_the_same_bits(followed: Outcome) -> None:
    assert run_live(CASE, Setup(), drawn()).rows.tobytes() == followed.rows.tobytes()


def test_a_live_reference_has_the_inverse_at_100_hz_no_velocity_gain_and_wide_limits() -> None:
    settings = live_settings(CASE, Settings(K_FF=(0.1, 0.1)))
    assert (settings.feedforward_period, settings.K_FF) == (0.01, (0.0, 0.0))
    Settings.model_validate(settings.model_dump())
    for name in ("speed_max", "acceleration_max"):
        value = getattr(settings, name)
        with pytest.raises(ValueError, match=name):
            Settings.model_validate(settings.model_dump() | {name: 1.001 * value})


def test_a_run_that_the_rig_breaks_off_is_an_error_with_its_cause() -> None:
    stiff = Setup(twin=TwinParameters(stiffness_scale=2.0))
    with pytest.raises(TendrilError, match=r"live_path: FAULT \(TRACKING_ERROR\) after"):
        run_live(Case("live_path", law="ff+p"), stiff, drawn(seconds=8.0))


def test_the_shipped_path_is_long_and_wide_enough_for_task_5() -> None:
    path = read_marker_path()
    assert path.t[-1] - path.t[0] == pytest.approx(30.0, abs=0.5)
    assert (np.ptp(path.p, axis=0) > [0.2, 0.16]).all()


def test_a_path_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=LIVE_PATH_FILE.name):
        read_marker_path(tmp_path / LIVE_PATH_FILE.name)
