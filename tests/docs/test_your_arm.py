"""The figures of docs/your-arm.md are those that its commands print."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from controller.research.identification.identify import IdentificationTask, identify
from controller.schema.actuator import Actuator, read_actuator, write_actuator
from tests.docs.blocks import EXAMPLES, ROOT, rows_after

pytestmark = pytest.mark.keyed("docs/your-arm.md", "docs/examples", "server/cli")

PAGE = (ROOT / "docs" / "your-arm.md").read_text()
TENDRIL = Path(sys.executable).parent / "tendril"
BASE = read_actuator(EXAMPLES / "base.toml")


@pytest.fixture(scope="module")
def found() -> Actuator:
    data = (EXAMPLES / "my_poses.csv", EXAMPLES / "my_decays.csv")
    return identify(IdentificationTask(data, BASE, profile="linear"))[-1].actuator


def residual(profile: str) -> float:
    (fit,) = identify(IdentificationTask((EXAMPLES / "my_poses.csv",), BASE, profile=profile))
    return next(one.rms for one in fit.misfits if one.name == "all markers")


def test_a_taper_takes_the_residual_down_to_the_noise() -> None:
    said = [float(one) for one in re.findall(r"(?:residual is|Now it is) ([\d.]+) mm", PAGE)]
    assert [round(residual(profile), 2) for profile in ("uniform", "linear")] == said


def test_what_went_in_comes_out_as_the_page_says(found: Actuator) -> None:
    assert found.EI is not None
    u1, back_1, u2, back_2 = found.pressure_map
    values = [
        [found.EI[1] / found.EI[0]],
        [1e6 * one for one in found.stiffening],
        [1e7 * one for one in found.stretching],
        [back_1 / u1, back_2 / u2],
    ]
    for (name, _, said), ours in zip(rows_after(PAGE, "went in, found are"), values, strict=True):
        assert [float(one) for one in said.split(", ")] == pytest.approx(ours, rel=0.006), name
    assert f"`u_max` is now {1e3 * found.u_max:.0f} mN m" in PAGE


@pytest.mark.process
def test_the_path_is_followed_as_well_as_the_page_says(found: Actuator, tmp_path: Path) -> None:
    write_actuator(found, tmp_path / "my_arm.toml")
    for file in ("base.toml", "my_path.csv"):
        (tmp_path / file).write_bytes((EXAMPLES / file).read_bytes())
    commands = re.findall(r"^tendril (track .+)$", PAGE, re.MULTILINE)
    for command, (name, said) in zip(commands, rows_after(PAGE, "The same path on"), strict=True):
        done = subprocess.run([TENDRIL, *command.split()], cwd=tmp_path, capture_output=True, text=True, timeout=120)
        rmse = re.search(r"^rmse +([\d.]+)", done.stdout, re.MULTILINE)
        assert rmse, done.stdout + done.stderr
        assert float(rmse[1]) == pytest.approx(float(said), rel=0.02), name
