"""The soft arm of four columns: recordings of an arm that we know, in the files of the public one."""

from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Array
from controller.errors import DataError
from controller.research.measured.arm import ARM, COLUMNS, FILES, FIRST, LENGTH, TIP, WINDOW_S, Condition, predicted
from controller.research.measured.sets import rows

pytestmark = pytest.mark.keyed()

TRUTH = np.array([1.47, 0.02, 1.0, 1.5, 1.1, 0.3, 0.13, 0.13, 0.15, 0.2])
HEADER = ["time", *(name for column in COLUMNS for name in column), *TIP]


def write(path: Path, seed: int, noise: float = 0.0, header: list[str] = HEADER) -> None:
    """Ten samples a second of an arm whose base is anywhere; the tip is seen in the window."""
    random, t = np.random.default_rng(seed), np.arange(1200) / 10
    swings = random.uniform(0.0, 4.0, (4, 1))
    p = 5.0 + swings * np.sin(2 * np.pi * 0.1 * t + random.uniform(0.0, 6.0, (4, 1)))
    tip: Array = np.zeros((3, t.size))
    seen = (t > WINDOW_S[0]) & (t < WINDOW_S[1])
    motion = predicted(Condition(t, p, np.ones_like(tip)), TRUTH)
    tip[:, seen] = random.uniform(0.1, 1.0, (3, 1)) + motion + random.normal(0.0, noise, motion.shape)
    pouches = np.vstack([np.tile(p[column], (len(names), 1)) for column, names in enumerate(COLUMNS)])
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, np.vstack([t, pouches, tip]).T, fmt="%.6f", delimiter=",", header=",".join(header), comments="")


def test_an_arm_that_is_known_is_met_to_its_noise(tmp_path: Path) -> None:
    for seed, inner in enumerate(FILES):
        write(tmp_path / "cloned" / inner, seed, noise=1e-4)
    [row] = rows(ARM, tmp_path)
    assert row["ours"] == pytest.approx(100 * np.sqrt(3) * 1e-4 / LENGTH, rel=0.05)
    assert row["baselines"]["a linear map of the pressures"] > 2 * row["ours"]
    assert row["baselines"]["no motion"] > 20 * row["ours"]
    assert len(row["files"]) == 31


def test_without_moments_nothing_moves_across() -> None:
    t = np.arange(1200) / 10
    one = Condition(t, np.full((4, t.size), 3.0) + np.sin(t), np.ones((3, t.size)))
    across = predicted(one, FIRST * ([1.0] * 6 + [0.0] * 4))  # four columns alike
    assert np.abs(across).max() < 1e-9


def test_files_that_are_not_there_are_named(tmp_path: Path) -> None:
    write(tmp_path / FILES[0], 0)
    [row] = rows(ARM, tmp_path)
    assert row["ours"] is None
    assert row["missing"] == list(FILES[1:])


@pytest.mark.parametrize("header", [["time"], [name.replace("mocap", "body") for name in HEADER]])
def test_a_table_of_something_else_is_named(tmp_path: Path, header: list[str]) -> None:
    for inner in FILES:
        write(tmp_path / inner, 0, header=header)
    with pytest.raises(DataError, match="no table with time, measured pressures and mocap_rigid_body"):
        rows(ARM, tmp_path)


def test_a_tip_that_is_hardly_seen_is_named(tmp_path: Path) -> None:
    for inner in FILES:
        write(tmp_path / inner, 0)
    lines = (tmp_path / FILES[3]).read_text().splitlines(keepends=True)
    (tmp_path / FILES[3]).write_text("".join(lines[:410]))
    with pytest.raises(DataError, match="the tip is hardly seen from 40 to 110 s"):
        rows(ARM, tmp_path)
