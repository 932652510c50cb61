"""The quick look shows every extreme of the recorded numbers, and finds the period of the reference."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from controller.errors import ParameterError
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from recordings.format.messages import Recording
from recordings.format.profiles import PROFILES, ProfileInfo
from recordings.read.period import find_phase
from recordings.read.quick import quick_look, thinned
from recordings.read.reader import read_rows
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows


def test_every_bin_shows_its_lowest_and_its_highest_value() -> None:
    values = np.random.default_rng(1).normal(size=(10_000, 2))
    values[1234, 0], values[:100, 1] = 50.0, np.nan
    shown = thinned(values, 200)
    assert shown.shape == (200, 2)
    for i, part in enumerate(np.split(values, 100)):
        expected = [[np.nan, np.nan], [part[:, 1].min(), part[:, 1].max()]][bool(i)]
        np.testing.assert_array_equal(np.sort(shown[2 * i : 2 * i + 2, 1]), expected)
    assert shown[:, 0].max() == 50.0
    np.testing.assert_array_equal(thinned(values, 10_000), values)


def test_a_ramp_stays_a_ramp() -> None:
    ramp = np.arange(1000.0)[:, None]
    assert (np.diff(thinned(ramp, 100)[:, 0]) > 0).all()
    assert (np.diff(thinned(-ramp, 100)[:, 0]) < 0).all()


def test_the_quick_look_holds_the_recorded_numbers(record: Callable[..., Recording], tmp_path: Path) -> None:
    done = record(telemetry_rows(6000))
    path = Store(tmp_path).path(done.id)
    rows, look = read_rows(path), json.loads(quick_look(path, 400))
    assert look["rows"] == 6000
    assert look["duration"] == pytest.approx(done.seconds)
    signals = {signal["key"]: signal for signal in look["signals"]}
    assert {len(signal["values"]) for signal in signals.values()} == {len(look["t"])} == {400}
    np.testing.assert_allclose(max(signals["p_ref.1"]["values"]), rows["p_ref"][:, 1].max(), atol=1e-6)
    np.testing.assert_allclose(max(signals["lateness_ns"]["values"]), rows["lateness_ns"].max(), rtol=1e-5)
    error = np.hypot(*rows["error"].T)
    np.testing.assert_allclose(max(signals["error.norm"]["values"]), np.nanmax(error), rtol=1e-5)
    track = {track["field"]: track for track in look["tracks"]}["p_ref"]
    elapsed = (rows["t_ns"] - rows["t_ns"][0]) * 1e-9
    at = np.searchsorted(elapsed, np.array(look["track_t"]) - 1e-6)
    np.testing.assert_allclose(np.column_stack([track["x"], track["y"]]), rows["p_ref"][at], atol=1e-6)


def test_only_the_signals_asked_for_are_given_and_an_unknown_one_is_named(
    record: Callable[..., Recording], tmp_path: Path
) -> None:
    path = Store(tmp_path).path(record(telemetry_rows(300)).id)
    look = json.loads(quick_look(path, 2000, ("residual", "u.0")))
    assert {signal["key"] for signal in look["signals"]} == {"residual", "u.0"}
    assert len(look["t"]) == 300
    with pytest.raises(ParameterError, match="nonsense"):
        quick_look(path, 2000, ("nonsense",))


def test_a_running_recording_is_shown_up_to_now(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path)
    try:
        recorder.start("running", rig_info(), Settings())
        id, shown = recorder.state().id, [0]
        for batch in batches(telemetry_rows(3000), 500):
            recorder.rows(batch)
            deadline = time.monotonic() + 10.0
            while shown[-1] < int(batch["tick"][-1]) - 1000 and time.monotonic() < deadline:
                time.sleep(0.05)
                shown.append(json.loads(quick_look(Store(tmp_path).path(id), 2000))["rows"])
        assert shown[-1] >= 1500
    finally:
        recorder.close()


@pytest.mark.parametrize("profile", PROFILES)
def test_a_cycle_is_found_in_what_was_tracked_whatever_came_before_it_and_after(
    tmp_path: Path, profile: ProfileInfo
) -> None:
    rows = telemetry_rows(30_000)  # a circle of 0.5 Hz
    t = np.arange(len(rows)) * 1e-3
    rows["mode"] = np.select([t < 12.0, t < 26.0], [Mode.HOLD, Mode.TRACK], Mode.HOLD)
    rows["p_ref"][t < 14.0] = [0.25, 0.0] + (rows["p_ref"][14_000] - [0.25, 0.0]) * np.clip(t[t < 14.0] - 12, 0, 2)[
        :, None
    ] / 2
    rows["p_ref"][t >= 26.0] = [0.1, 0.1]
    recorder = Recorder(tmp_path)
    recorder.start("run", rig_info(), Settings(), Context(profile=profile.name))
    for batch in batches(rows, 500):
        recorder.rows(batch)
    look = json.loads(quick_look(Store(tmp_path).path(recorder.stop().id), 400))
    recorder.close()
    assert look["period"] == pytest.approx(2.0, rel=2e-3)
    assert 14.0 <= look["cycle_start"] < 16.1
    assert look["cycle_end"] == pytest.approx(26.0, abs=0.05)


@pytest.mark.parametrize("period", [0.5, 2.0, 7.0])
def test_the_period_and_the_beginning_of_a_cycle_are_found(period: float) -> None:
    t = np.arange(0.0, 30.0, 1e-3)
    turn = 2 * np.pi * (t - 0.3) / period
    found, start = find_phase(t, 0.2 + 0.02 * np.cos(turn), 0.01 * np.sin(turn) + 0.004 * np.sin(2 * turn))
    assert found == pytest.approx(period, rel=2e-3)
    assert (start - 0.3 + period / 2) % period - period / 2 == pytest.approx(0.0, abs=0.03 * period)


def test_what_does_not_repeat_has_no_period() -> None:
    t = np.arange(0.0, 10.0, 1e-3)
    assert find_phase(t, 0.01 * t, np.zeros_like(t)) == (None, 0.0)
    assert find_phase(t, np.zeros_like(t), np.zeros_like(t)) == (None, 0.0)
    assert find_phase(t, None, None) == (None, 0.0)


@pytest.mark.parametrize("x, y", [(1, 1), (1, 2), (2, 1), (2, 3), (3, 2), (3, 4)])
def test_a_cycle_begins_at_the_same_place_wherever_the_recording_was_begun(x: int, y: int) -> None:
    t, begins = np.arange(0.0, 30.0, 1e-3), []
    for since in (0.0, 0.5, 1.7, 3.9):
        turn = 2 * np.pi * (t + since) / 4.0
        found, start = find_phase(t, *np.round([0.03 * np.cos(x * turn), 0.03 * np.sin(y * turn)], 5))
        assert found == pytest.approx(4.0, rel=1e-4)
        begins.append((start + since) / 4.0)
    apart = np.array(begins) - begins[0]
    np.testing.assert_allclose(apart - np.round(apart), 0.0, atol=1e-3)


def test_the_period_is_that_of_the_run_whatever_came_before_and_after(
    record: Callable[..., Recording], tmp_path: Path
) -> None:
    rows = telemetry_rows(12_000)
    still = (rows["tick"] < 3000) | (rows["tick"] >= 11_000)
    rows["p_ref"][still], rows["mode"] = (0.05, 0.1), np.where(still, Mode.HOLD, Mode.TRACK)
    look = json.loads(quick_look(Store(tmp_path).path(record(rows).id), 400))
    assert look["period"] == pytest.approx(2.0, rel=1e-3)
    assert (look["cycle_start"] + 1.0) % 2.0 == pytest.approx(1.0, abs=0.02)  # x is largest at even seconds
