"""`tendril identify` on files as a user has them: one command from data to an actuator that the rig reads."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes
from controller.errors import TendrilError
from controller.schema.actuator import PRESETS, read_actuator
from server.cli.main import app
from server.cli.research.identify import reach_note
from tests.oracles import Chain

pytestmark = [pytest.mark.process, pytest.mark.keyed("server/cli/research/commands.py")]

TENDRIL = Path(sys.executable).parent / "tendril"
TRUTH = PRESETS["P1"].model_copy(update={"k": (0.09, 0.05), "name": "truth"})


def chain_points(angles: Array, length: float) -> Array:
    """Middle and tip (2,2) [m] of a chain of equal rods."""
    ends = length / angles.size * np.cumsum([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(ends[:, [angles.size // 2 - 1, -1]].T)


@pytest.fixture
def poses(tmp_path: Path) -> Path:
    """Static poses of a dense solve, in kPa and mm, with 0.2 mm of noise."""
    model, random = build_rod(TRUTH, 40), np.random.default_rng(1)
    rows = ["# tapered actuator, two markers", "p1_kpa,p2_kpa,x1_mm,y1_mm,x2_mm,y2_mm"]
    for u in random.uniform(-0.04, 0.04, (20, 2)):
        points = chain_points(np.linalg.solve(Chain(model).hinges(model.k), model.T_theta @ u), TRUTH.length)
        values = [*(1e-3 * u * np.array(TRUTH.pressure_map)), *(1e3 * points.ravel() + random.normal(0.0, 0.2, 4))]
        rows.append(",".join(f"{value:.3f}" for value in values))
    file = tmp_path / "poses.csv"
    file.write_text("\n".join(rows) + "\n")
    return file


@pytest.fixture
def decays(tmp_path: Path) -> Path:
    """Three decays of the truth's first mode with zeta = 0.06, 100 Hz, 0.2 mm of noise."""
    model, random = build_rod(TRUTH, 10)._replace(b=np.zeros(10), alpha=0.0), np.random.default_rng(2)
    omega = float(np.abs(natural_modes(model, np.zeros(10))).min())
    t = np.arange(1500) * 0.01
    rows = ["ID,x1,y1"]
    for number, height in enumerate((0.03, -0.02, 0.025)):
        y = height * np.exp(-0.06 * omega * t) * np.cos(omega * np.sqrt(1 - 0.06**2) * t)
        noise = random.normal(0.0, 2e-4, (2, t.size))
        rows += [f"{number},{0.25 + a:.6f},{b:.6f}" for a, b in zip(noise[0], y + noise[1], strict=True)]
    file = tmp_path / "decays.csv"
    file.write_text("\n".join(rows) + "\n")
    return file


def test_poses_and_decays_become_one_actuator_and_one_page(tmp_path: Path, poses: Path, decays: Path) -> None:
    out, page = tmp_path / "mine.toml", tmp_path / "mine.html"
    options = ["--profile", "linear", "--ids", "0-2", "--out", out, "--report", page]
    done = subprocess.run([TENDRIL, "identify", poses, decays, *options], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    found = read_actuator(out)
    assert found.name == "mine"
    assert found.k == pytest.approx(TRUTH.k, rel=0.02)
    model = build_rod(found, 10)
    modes = natural_modes(model, model.rest)
    first = modes[np.argmin(np.abs(modes))]
    assert -first.real / abs(first) == pytest.approx(0.06, rel=0.02)
    text = page.read_text()
    assert all(part in text for part in ("Stiffness from static", "zeta", "<svg", "N m/rad", "poses.csv", "mine"))


def test_a_damping_ratio_that_was_measured_otherwise_is_that_of_the_models_first_mode(
    tmp_path: Path, poses: Path
) -> None:
    out, page = tmp_path / "mine.toml", tmp_path / "mine.html"
    app(["identify", str(poses), "--zeta", "0.12", "--out", str(out), "--report", str(page)], standalone_mode=False)
    found = read_actuator(out)
    model = build_rod(found, found.table_rods)
    modes = natural_modes(model, model.rest)
    first = modes[np.argmin(np.abs(modes))]
    assert -first.real / abs(first) == pytest.approx(0.12, rel=0.01)
    assert "Damping as given" in page.read_text() and "# zeta = 0.12" in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["{poses}", "{decays}", "--zeta", "0.1"], "has free decays, which tell it; leave one of both out"),
        (["{decays}", "--robust"], "decays.csv has no static test, whose values it weighs"),
        (["{poses}", "--ids", "3"], "has no free decays to choose from"),
        (["{decays}", "--ids", "7"], "ID 7 is not there (IDs 0 to 2 are)"),
        (["{poses}", "--profile", "cubic"], "profile = 'cubic' is not one of auto, uniform, linear, scaled"),
        (["{poses}", "{poses}"], "belong in one file"),
        (["nothing.csv"], "nothing.csv cannot be read"),
        (["{poses}", "--actuator", "P9"], "actuator = 'P9' is not one of P1, P2, P3"),
        (["{poses}", "--out", "mine.json"], "out = 'mine.json' does not end in .toml"),
        (["{poses}", "--out", "/nowhere/mine.toml"], "/nowhere/mine.toml cannot be written"),
    ],
)
def test_a_mistake_is_named_and_nothing_is_written(
    tmp_path: Path, poses: Path, decays: Path, arguments: list[str], complaint: str
) -> None:
    given = [argument.format(poses=poses, decays=decays) for argument in arguments]
    out = [] if "--out" in given else ["--out", str(tmp_path / "mine.toml")]
    with pytest.raises(TendrilError) as caught:
        app(["identify", *given, *out], standalone_mode=False)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "mine.toml").exists()


def test_decays_that_never_swing_are_refused_with_the_file(tmp_path: Path) -> None:
    file = tmp_path / "creep.csv"
    file.write_text("ID,x1,y1\n" + "".join(f"0,0.25,{np.exp(-i / 50):.6f}\n" for i in range(300)))
    with pytest.raises(TendrilError, match=f"{file}: 0 peaks stand out of the noise"):
        app(["identify", str(file), "--out", str(tmp_path / "mine.toml")], standalone_mode=False)


def test_shapes_that_the_identified_arm_can_follow_no_more_are_named_with_how_far_they_are() -> None:
    base = PRESETS["P1"]
    stiffer = base.model_copy(update={"k": tuple(1.6 * k for k in base.k)})
    (note,) = reach_note(stiffer, base)
    assert re.search(r"u_max = 60 mN m .*circle_1hz[^:;]*: the path leaves the reach by [\d.]+ mm", note), note
    assert reach_note(base, stiffer) == reach_note(base, base) == ()
