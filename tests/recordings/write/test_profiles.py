"""The profile `standard`: every tick that it promises, no further from the number than it says, and small."""

from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.layout import quantity
from controller.schema.messages import Telemetry
from controller.schema.parameters import Settings
from recordings.format import tool
from recordings.format.profiles import CLOCK, PROFILES, RESOLUTION, SLOW_FIELDS
from recordings.read.playback import read_playback
from recordings.read.reader import read_rows, read_times
from recordings.size import megabytes_per_hour, twin_rows
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

BACKBONES = {"markers", "backbone", "twin_backbone"}
SENSOR = {"m": 1e-5, "Pa": 10.0, "N m": 1e-5, "ns": 1.1e3}
"""What the rounding stays below."""


@pytest.fixture
def standard(recorder: Recorder, tmp_path: Path) -> tuple[Rows, Path]:
    rows = telemetry_rows(2003)
    id = recorder.start("standard", rig_info(), Settings(), Context(profile="standard")).id
    for batch in batches(rows):
        recorder.rows(batch)
    assert recorder.stop().profile == "standard"
    return rows, tmp_path / f"{id}.rrd"


def test_every_tick_is_there_within_the_stated_rounding(standard: tuple[Rows, Path]) -> None:
    rows, path = standard
    found = read_rows(path)
    for name in set(Telemetry.model_fields) - SLOW_FIELDS - BACKBONES:
        step = 0.0 if name == CLOCK else RESOLUTION.get(quantity(Telemetry, name).unit, 0.0)
        assert found[name].dtype == rows[name].dtype
        np.testing.assert_allclose(found[name], rows[name], rtol=0, atol=step / 2, err_msg=name)
    assert all(step < SENSOR[unit] for unit, step in RESOLUTION.items())
    assert read_times(path)[0].tolist() == rows["tick"].tolist()


def test_what_is_slow_comes_with_its_ticks_at_100_hz(standard: tuple[Rows, Path]) -> None:
    rows, path = standard
    found = read_rows(path)
    for name in SLOW_FIELDS | {"backbone"}:
        ticks, step = found[f"{name}_tick"], RESOLUTION.get(quantity(Telemetry, name).unit, 0.0)
        assert ticks.tolist() == list(range(0, 2003, 10)), name
        np.testing.assert_allclose(found[name], rows[name][ticks], rtol=0, atol=step / 2, err_msg=name)


@pytest.mark.process
def test_rerun_finds_nothing_wrong_before_and_after_compaction(standard: tuple[Rows, Path]) -> None:
    rows, path = standard
    tool.run("rrd", "verify", str(path), timeout=60)
    assert Store(path.parent).compact(path.stem).rows == len(rows)
    tool.run("rrd", "verify", str(path), timeout=60)
    assert read_playback(path).duration == pytest.approx(2.0, abs=0.05)


@pytest.mark.keyed()
@pytest.mark.process
def test_an_hour_of_standard_takes_less_than_710_mb_in_the_busiest_run(tmp_path: Path) -> None:
    rows = laps(twin_rows("circle_2hz")[2000:], 4)
    _, standard = megabytes_per_hour(rows, "standard", tmp_path)
    _, full = megabytes_per_hour(rows, "full", tmp_path)
    assert standard < 710 < full
    assert {info.name: info.megabytes_per_hour for info in PROFILES}["standard"] <= 700


def laps(rows: Rows, count: int) -> Rows:
    """The same rows `count` times, one after the other: in a short file the chunks' heads weigh too much."""
    out = np.tile(rows, count)
    for name, step in (("tick", 1), ("slot", 1), ("t_ns", 1_000_000)):
        out[name] += np.repeat(np.arange(count), len(rows)) * len(rows) * step
    return out
