"""What a file holds besides its rows, and what it leaves behind in the process that wrote it."""

import subprocess
import sys
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from controller.schema.parameters import Settings
from recordings.format.about import About
from recordings.write.rrd import RrdFile
from tests.recordings.synthetic import rig_info, telemetry_rows

GROWTH_MAX_MB = 0.5
"""Per file, beyond what the first ten need: rerun kept 2.8 MB of each when the layout was given to `save`."""


@pytest.mark.parametrize("rows", [0, 3])
@pytest.mark.parametrize("flushed", [False, True])
def test_the_layout_is_in_the_smallest_file(tmp_path: Path, rows: int, flushed: bool) -> None:
    for k in range(10):  # rerun reads the layout apart: a file closed at once must hold it nevertheless
        file = RrdFile(tmp_path / f"{k}.rrd", About(f"{k}", "name", rig_info(), Settings(), "full"))
        if rows:
            file.write(telemetry_rows(rows))
        if flushed:
            file.flush()
        file.close()
        found = RrdReader(tmp_path / f"{k}.rrd")
        assert [entry.recording_id for entry in found.recordings()] == [f"{k}"]
        assert [entry.application_id for entry in found.blueprints()] == ["tendril"]


@pytest.mark.process
def test_a_closed_file_leaves_no_memory_behind(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.recordings.write_and_forget", str(tmp_path), "10", "30"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert float(done.stdout) < GROWTH_MAX_MB
