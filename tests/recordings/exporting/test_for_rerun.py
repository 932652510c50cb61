"""The copy of a recording that rerun's viewer shows beside the page, read by rerun's own reader."""

from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from controller.errors import RecordingError
from recordings.exporting.for_rerun import for_rerun
from recordings.format.chunks import numbers
from recordings.format.signals import GROUPS
from recordings.read.reader import read_rows
from tests.e2e.recorded import record_circle

SCALES = {"/tip/x": 1e3, "/error": 1e3, "/pressures": 1e-3, "/u": 1e3, "/timing": 1e-3}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    return folder / f"{record_circle(folder, 'circle', 2.0).id}.rrd"


def logged(path: Path, entity: str, component: str) -> np.ndarray:
    """All that is logged there, flat, in the order of the file."""
    found = []
    for chunk in RrdReader(path).stream().filter(content=[entity]):
        batch = chunk.to_record_batch()
        if component in batch.schema.names:
            found.append(numbers(batch.column(component)))
    return np.concatenate(found)


def test_plots_are_in_the_units_that_people_read_and_all_rows_are_there(recording: Path, tmp_path: Path) -> None:
    for_rerun(recording, copy := tmp_path / "copy.rrd", dark=True)
    for group in GROUPS:
        if group.path in SCALES:
            before = logged(recording, group.path, "Scalars:scalars")
            after = logged(copy, group.path, "Scalars:scalars")
            assert np.array_equal(np.sort(after), np.sort(before * SCALES[group.path]), equal_nan=True), group.path
            names = logged(copy, group.path, "SeriesLines:names").tolist()
            assert names[-len(group.series) :] == [series.shown[0] for series in group.series]
    assert "measured tip x [mm]" in logged(copy, "/tip/x", "SeriesLines:names")


def test_the_recording_itself_stays_as_it_is_in_si(recording: Path, tmp_path: Path) -> None:
    before = recording.read_bytes()
    for_rerun(recording, tmp_path / "copy.rrd", dark=False)
    assert recording.read_bytes() == before
    assert np.nanmax(np.abs(read_rows(recording, ["p_meas"])["p_meas"])) < 1.0


def test_its_ground_follows_the_theme_and_signals_without_a_plot_are_left_out(recording: Path, tmp_path: Path) -> None:
    colours = []
    for dark in (True, False):
        for_rerun(recording, copy := tmp_path / f"{dark}.rrd", dark=dark)
        colours.append(int(logged(copy, "/plan/grid", "LineStrips2D:colors")[-1]) >> 8)
        paths = {str(chunk.entity_path) for chunk in RrdReader(copy).stream()}
        assert "/state" not in paths
        assert {"/plan/observer", "/mode", "/log"} <= paths
    assert colours == [0x2C3138, 0xE3E6EA]


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    (wrong := tmp_path / "wrong.rrd").write_bytes(b"nothing")
    with pytest.raises(RecordingError):
        for_rerun(wrong, tmp_path / "copy.rrd", dark=True)
