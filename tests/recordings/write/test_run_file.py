"""A simulated run as a recording: rerun takes it, and its layout is the live rig's."""

from pathlib import Path

import numpy as np
import pytest

from controller.errors import RecordingError
from controller.schema.parameters import RigParameters, Settings
from recordings.format import tool
from recordings.read.reader import read_about, read_rows
from recordings.write.run_file import THINNED, write_run
from tests.recordings.synthetic import telemetry_rows


@pytest.mark.process
def test_every_so_many_ticks_are_read_back_bit_for_bit(tmp_path: Path) -> None:
    rows, path = telemetry_rows(3210), tmp_path / "vu_P1_ff+pi.rrd"
    write_run(rows, path, "vu P1 ff+pi", RigParameters(), Settings())
    tool.run("rrd", "verify", str(path), timeout=60)
    found, thin = read_rows(path), rows[::THINNED]
    for name in ("tick", "t_ns", "p_ref", "p_hat", "u", "pressure_meas"):
        np.testing.assert_array_equal(found[name], thin[name], err_msg=name)
    assert found["twin_backbone_tick"].tolist() == list(range(0, 3210, 10))


def test_it_says_what_it_is(tmp_path: Path) -> None:
    path, settings = tmp_path / "run.rrd", Settings(K_P=(0.1, 0.1))
    write_run(telemetry_rows(10), path, "run", RigParameters(), settings)
    info, found = read_about(path)
    assert (info.twin, info.policy, info.parameters, found) == (True, "simulated", RigParameters(), settings)


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"run\.rrd cannot be written"):
        write_run(telemetry_rows(10), tmp_path / "none" / "run.rrd", "run", RigParameters(), Settings())
