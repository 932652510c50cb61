"""The library around the core, as a Teensy has it: built for this machine, at a port that never runs dry."""

import subprocess
from pathlib import Path

import pytest

from controller.virtual.firmware import FLAGS, build, compiler, firmware_folder

pytestmark = [
    pytest.mark.process,
    pytest.mark.keyed("firmware", "tests/firmware"),
    pytest.mark.skipif(compiler() is None, reason="no compiler"),
]
ARDUINO = Path(__file__).parent / "arduino"


def test_bytes_that_form_no_frame_do_not_keep_the_sensors_from_being_read(tmp_path: Path) -> None:
    program = tmp_path / "noise"
    build(ARDUINO / "noise.cpp", program, (*FLAGS, f"-I{ARDUINO}", f"-I{firmware_folder() / 'src'}"))
    assert subprocess.run([program], timeout=60).returncode == 0
