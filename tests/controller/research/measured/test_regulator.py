"""Takes of a regulator: files as MATLAB writes them, of a regulator whose dead time and lag are known."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from controller.arrays import Array
from controller.errors import DataError
from controller.research.measured.regulator import FILES, REGULATOR, Take, predicted, read_take
from controller.research.measured.sets import rows

pytestmark = pytest.mark.keyed()

TRUE = (19.8, 1.2, 0.04, 0.02)
"""Gain [kPa/V], offset [kPa], dead time and lag [s]."""


def asked(t: Array, kind: str) -> Array:
    """What is asked for [V]: steps, or a sweep of frequencies."""
    return np.asarray(5.0 + 4.0 * (np.sign(np.sin(t)) if "repeating" in kind else np.sin(0.3 * t**2)))


def written(folder: Path, inner: str, step: float = 0.008) -> Path:
    """One take [V, V, hPa], with samples between the even ones in some."""
    path = folder / inner
    path.parent.mkdir(parents=True, exist_ok=True)
    t = step * np.arange(2500)
    p = predicted(Take(t, asked(t, inner), np.full(1, 100.0)), *TRUE)
    if "repeating" in inner:
        more = np.sort(np.append(t, t[100:120] + step / 2))
        t, p = more, np.interp(more, t, p)
    with h5py.File(path, "w") as file:
        held = file.create_group("#refs#")
        held["a"] = np.zeros((1, 1096), dtype=np.uint8)
        held["p"] = t[None]
        held["z"] = np.column_stack([asked(t, inner), p / 20.0, 10.0 * p])
    return path


def test_a_regulator_of_one_dead_time_and_one_lag_is_found(tmp_path: Path) -> None:
    for inner in FILES:
        written(tmp_path / "SoftRoboticSetupFesto", inner)
    median, worst = rows(REGULATOR, tmp_path)
    assert (median["metric"], worst["metric"]) == ("median rms", "worst rms")
    for row in (median, worst):
        assert row["ours"] is not None
        assert row["ours"] < 0.5
        assert all(value > 2.0 * row["ours"] for value in row["baselines"].values())
    assert len(median["files"]) == 10


def test_a_take_that_is_not_there_is_named(tmp_path: Path) -> None:
    written(tmp_path, FILES[0])
    for row in rows(REGULATOR, tmp_path):
        assert row["ours"] is None
        assert row["missing"] == list(FILES[1:])
        assert list(row["files"]) == [FILES[0]]


def test_a_file_of_something_else_is_named(tmp_path: Path) -> None:
    text, empty = tmp_path / "text.mat", tmp_path / "empty.mat"
    text.write_text("MATLAB 5.0")
    with h5py.File(empty, "w") as file:
        file.create_group("#refs#")
    for path in (text, empty):
        with pytest.raises(DataError, match=path.name):
            read_take(path)
