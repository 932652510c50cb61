"""Metrics of a recording against numbers worked out by hand, and against a run's own result card."""

import math

import numpy as np
import pytest

from controller.arrays import Array, Rows
from controller.schema.modes import Mode
from recordings.format.messages import Metrics
from recordings.read.metrics import cycles_of, followed, lost_ticks, metrics_of, rms, unsensed_rms
from recordings.read.period import find_period
from server.runs.tally import Tally
from tests.recordings.synthetic import telemetry_rows

MS = 1_000_000


def rows_of(p_ref: Array, p_meas: Array, **more: Array) -> dict[str, Array]:
    n = len(p_ref)
    tick = np.arange(n)
    return {"tick": tick, "t_ns": tick * MS, "slot": tick.copy(), "p_ref": p_ref, "p_meas": p_meas, **more}


def circle(t: Array, frequency: float, radius: float = 0.04) -> Array:
    angle = 2 * np.pi * frequency * t
    return radius * np.stack([np.cos(angle), np.sin(angle)], 1)


def test_a_constant_offset_of_3_and_4_mm_has_an_error_of_5_mm() -> None:
    found = metrics_of(rows_of(np.zeros((2000, 2)), np.full((2000, 2), (0.003, -0.004))))
    assert found.rmse == pytest.approx(0.005)
    assert found.max_error == pytest.approx(0.005)
    assert found.sse == pytest.approx(0.005)
    assert found.ise == pytest.approx(2.0 * 25e-6)
    assert (found.lag_deg_x, found.lag_deg_y) == (None, None)
    assert (found.lost, found.on_time_share) == (0, 1.0)


def test_rmse_is_not_the_mean_and_the_largest_error_is_one_row() -> None:
    found = metrics_of(rows_of(np.zeros((4, 2)), np.array([(0, 0), (0.002, 0), (0, 0), (0, -0.004)])))
    assert found.rmse == pytest.approx(math.sqrt((4e-6 + 16e-6) / 4))
    assert found.max_error == pytest.approx(0.004)


def test_the_steady_state_error_is_the_mean_of_the_last_tenth() -> None:
    p_meas = np.full((20, 2), (0.0, 0.001))
    p_meas[18:] = (0.003, 0.0), (0.0, -0.005)
    assert metrics_of(rows_of(np.zeros((20, 2)), p_meas)).sse == pytest.approx(0.004)


def test_a_row_without_its_marker_counts_for_no_error() -> None:
    p_meas = np.array([(0.003, 0.004), (np.nan, np.nan), (0.0, 0.0)])
    found = metrics_of(rows_of(np.zeros((3, 2)), p_meas, residual=np.array([0.001, np.nan, 0.003])))
    assert found.rmse == pytest.approx(math.sqrt(25e-6 / 2))
    assert found.sse == 0.0
    assert found.residual_rms == pytest.approx(math.sqrt(5e-6))


def test_what_was_never_seen_or_not_recorded_is_null() -> None:
    unseen = metrics_of(rows_of(np.zeros((5, 2)), np.full((5, 2), np.nan)))
    assert unseen == Metrics(lost=0, on_time_share=1.0)
    assert metrics_of({"tick": np.arange(3), "t_ns": np.arange(3)}) == Metrics()


def test_one_row_has_an_error_and_no_share_of_slots_and_no_rows_have_nothing() -> None:
    one = metrics_of(rows_of(np.zeros((1, 2)), np.full((1, 2), (0.003, 0.004)), saturated=np.array([1])))
    assert one.rmse == pytest.approx(0.005)
    assert one.ise == pytest.approx(25e-9)
    assert (one.lost, one.on_time_share, one.saturated_share) == (0, None, 1.0)
    none = rows_of(np.zeros((0, 2)), np.zeros((0, 2)), saturated=np.zeros(0), residual=np.zeros(0))
    assert metrics_of(none) == Metrics()
    assert cycles_of(none) == []


def test_the_share_of_saturation_counts_ticks() -> None:
    saturated = np.array([1, 0, 0, 1, 0, 0, 0, 0])
    assert metrics_of({"tick": np.arange(8), "saturated": saturated}).saturated_share == 0.25


def test_the_share_of_the_feedback_is_a_ratio_of_mean_lengths() -> None:
    u_fb, u_ff = np.array([(0.0, 0.003), (0.004, 0.0)]), np.full((2, 2), (0.03, 0.04))
    found = metrics_of({"tick": np.arange(2), "u_fb": u_fb, "u_ff": u_ff}).feedback_share
    assert found == pytest.approx(0.0035 / 0.0535)
    assert metrics_of({"tick": np.arange(2), "u_fb": 0 * u_ff, "u_ff": 0 * u_ff}).feedback_share is None
    assert metrics_of({"tick": np.arange(2), "u_fb": 0 * u_fb, "u_ff": u_ff}).feedback_share == 0.0


def test_an_import_without_torques_has_no_share_of_the_feedback() -> None:
    unknown = np.full((2, 2), np.nan)
    assert metrics_of({"tick": np.arange(2), "u_fb": unknown, "u_ff": unknown}).feedback_share is None


def test_slots_are_lost_and_ticks_missing_in_the_file_are_not() -> None:
    assert lost_ticks(np.array([10, 11, 14, 15]), np.array([10, 11, 12, 13])) == (2, 3 / 5)
    assert lost_ticks(np.array([10, 11, 111, 112]), np.array([10, 11, 111, 112])) == (0, 1.0)
    restarted = lost_ticks(np.array([500, 501, 0, 1, 3]), np.array([400, 401, 0, 1, 2]))
    assert restarted == (1, 3 / 4)


@pytest.mark.parametrize("frequency, lag", [(0.5, 0.03), (1.0, 0.05), (3.0, 0.02)])
def test_a_circle_that_follows_late_lags_by_its_angle(frequency: float, lag: float) -> None:
    t = np.arange(7000) * 1e-3
    approach = np.linspace((0.0, 0.02), (0.04, 0.0), 1000, endpoint=False)
    p_ref = np.vstack([approach, circle(t, frequency)])
    p_meas = np.vstack([approach, circle(t - lag, frequency)])
    p_meas[3000:3010] = np.nan
    found = metrics_of(rows_of(p_ref, p_meas))
    assert found.lag_deg_x == pytest.approx(360 * frequency * lag, abs=0.1)
    assert found.lag_deg_y == pytest.approx(360 * frequency * lag, abs=0.1)
    cycles = cycles_of(rows_of(p_ref, p_meas))
    assert len(cycles) == int(7 * frequency)
    chord = 2 * 0.04 * math.sin(math.pi * frequency * lag)
    for cycle in cycles:
        assert cycle.rmse == pytest.approx(chord, rel=0.02)
        assert cycle.lag_deg_x == pytest.approx(360 * frequency * lag, rel=0.05)


def test_each_axis_of_a_figure_of_eight_lags_at_its_own_frequency() -> None:
    def eight(t: Array) -> Array:
        return np.stack([0.03 * np.sin(np.pi * t), 0.02 * np.sin(2 * np.pi * t)], 1)

    t = np.arange(6000) * 1e-3
    found = metrics_of(rows_of(eight(t), eight(t - 0.02)))
    assert found.lag_deg_x == pytest.approx(0.02 * 180, abs=0.05)
    assert found.lag_deg_y == pytest.approx(0.02 * 360, abs=0.05)
    assert len(cycles_of(rows_of(eight(t), eight(t - 0.02)))) == 3


@pytest.mark.parametrize(
    "p_ref",
    [
        np.zeros((5000, 2)),
        np.linspace((0.0, 0.0), (0.1, 0.1), 5000),
        circle(np.arange(1900) * 1e-3, 1.0),
        circle(np.arange(5000) * 1e-3, 1.0) * np.linspace(1.0, 2.0, 5000)[:, None],
        np.full((100, 2), np.nan),
        np.cumsum(np.random.default_rng(1).normal(0, 1e-3, (5000, 2)), axis=0),
    ],
)
def test_what_does_not_repeat_itself_has_no_period(p_ref: Array) -> None:
    assert find_period(p_ref) is None


def test_only_the_rows_of_a_run_count_where_there_was_one() -> None:
    mode = np.repeat([Mode.HOLD, Mode.TRACK, Mode.HOLD], 100)
    p_meas = np.where((mode == Mode.TRACK)[:, None], (0.003, 0.004), (1.0, 1.0))
    rows = rows_of(np.zeros((300, 2)), p_meas, mode=mode)
    assert metrics_of(rows).rmse == pytest.approx(0.005)
    rows["mode"] = np.full(300, Mode.HOLD)
    assert metrics_of(rows).rmse == pytest.approx(math.sqrt((100 * 25e-6 + 200 * 2.0) / 300))


def test_the_unsensed_rods_are_compared_where_both_backbones_are_known() -> None:
    ours, twins = np.zeros((4, 21, 2), np.float32), np.zeros((4, 21, 2), np.float32)
    twins[:, 2:20] = (0.003, 0.004)
    twins[:, 20] = (7.0, 7.0)  # rod 10, which is sensed
    twins[0] = 9.0
    rows = {
        "tick": np.arange(50),
        "sensed": np.full(50, 1 << 9),
        "backbone": ours,
        "backbone_tick": np.array([0, 10, 20, 30]),
        "twin_backbone": twins,
        "twin_backbone_tick": np.array([5, 10, 20, 30]),
    }
    assert unsensed_rms(rows) == pytest.approx(0.005)
    assert unsensed_rms(rows | {"sensed": np.full(50, 1023)}) is None
    assert unsensed_rms(rows | {"twin_backbone": twins[:0], "twin_backbone_tick": np.zeros(0)}) is None


def test_a_run_has_the_figures_of_its_result_card() -> None:
    rows: Rows = telemetry_rows(8000)
    rows["mode"] = Mode.TRACK
    tally = Tally((0.5, 0.5), 1e-3)
    tally.add(rows)
    card = tally.figures()
    found = metrics_of({name: rows[name] for name in rows.dtype.names if "backbone" not in name and name != "markers"})
    for name in ("rmse", "max_error", "saturated_share"):
        assert getattr(found, name) == pytest.approx(getattr(card, name)), name
    for name in ("lag_deg_x", "lag_deg_y"):
        assert getattr(found, name) == pytest.approx(getattr(card, name), abs=0.1), name
    assert found.on_time_share == pytest.approx(card.on_time_share, abs=2e-4)
    assert found.lost == rows["slot"][-1] - rows["tick"][-1] - rows["slot"][0] + rows["tick"][0]


def test_rms_of_vectors_is_that_of_their_lengths() -> None:
    assert rms(np.array([(3.0, 4.0), (0.0, 5.0), (np.nan, 1.0)])) == 5.0
    assert rms(np.zeros((0, 2))) is None


def test_what_was_recorded_at_fewer_ticks_is_cut_by_its_own_ticks() -> None:
    rows = rows_of(np.zeros((100, 2)), np.full((100, 2), (0.003, 0.004)), mode=np.repeat([Mode.HOLD, Mode.TRACK], 50))
    slow = {"energy": np.arange(10.0), "energy_tick": np.arange(0, 100, 10)}
    part = followed(rows | slow)
    assert part["tick"].tolist() == list(range(50, 100))
    assert (part["energy"].tolist(), part["energy_tick"].tolist()) == ([5, 6, 7, 8, 9], [50, 60, 70, 80, 90])
    assert metrics_of(rows | slow).rmse == pytest.approx(0.005)


def test_what_leads_into_a_run_does_not_count_where_the_recording_knows_it() -> None:
    mode = np.repeat([Mode.HOLD, Mode.TRACK, Mode.HOLD], 100)
    p_meas = np.zeros((300, 2))
    p_meas[100:150], p_meas[150:200] = (1.0, 1.0), (0.003, 0.004)
    rows = rows_of(np.zeros((300, 2)), p_meas, mode=mode)
    assert metrics_of(rows).approach is None
    found = metrics_of(rows | {"approach": np.isin(np.arange(300), np.arange(100, 150))})
    assert (found.approach, found.rmse) == (pytest.approx(0.05), pytest.approx(0.005))
    led_in_only = metrics_of(rows | {"approach": mode == Mode.TRACK})
    assert (led_in_only.approach, led_in_only.rmse) == (pytest.approx(0.1), None)
