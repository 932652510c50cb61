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


def run(name: str, folder: Path, *flags: str) -> int:
    """What the program `name` beside Arduino.h ends with."""
    build(ARDUINO / f"{name}.cpp", folder / name, (*FLAGS, *flags, f"-I{ARDUINO}", f"-I{firmware_folder() / 'src'}"))
    return subprocess.run([folder / name], timeout=60).returncode


def test_bytes_that_form_no_frame_do_not_keep_the_sensors_from_being_read(tmp_path: Path) -> None:
    assert run("noise", tmp_path) == 0


def test_a_teensy_that_hangs_vents_and_starts_again(tmp_path: Path) -> None:
    """Its registers are variables here: no one has run it on a real one."""
    assert run("teensy", tmp_path, "-D__IMXRT1062__") == 0
