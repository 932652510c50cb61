"""The hanging tentacle: poses that others measured (tests/data/soromox, MIT licence), and poses that we know."""

from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError
from controller.research.measured.sets import rows
from controller.research.measured.tentacle import FILE, FIRST, TENTACLE, TORQUES, markers

pytestmark = pytest.mark.keyed("tests/data/soromox")

DATA = Path(__file__).parents[3] / "data"


def test_a_planar_rod_with_stretch_is_nearer_than_the_published_one() -> None:
    unseen, every = rows(TENTACLE, DATA)
    assert unseen["ours"] is not None
    assert every["ours"] is not None
    assert unseen["ours"] < 14.5 < unseen["baselines"]["without stretch"]
    assert every["ours"] < 13.5 < every["baselines"]["their rod, fitted on 8 poses"]


def test_poses_of_a_known_tentacle_are_met(tmp_path: Path) -> None:
    truth = np.array([3.2e5, 1500.0, 1.1, 0.03, -0.02, 0.9])
    (path := tmp_path / "cloned" / FILE).parent.mkdir(parents=True)
    np.save(path, np.array([markers(truth, torques) for torques in TORQUES]))
    for row in rows(TENTACLE, tmp_path):
        assert row["ours"] == pytest.approx(0.0, abs=0.1)
        assert row["baselines"]["without stretch"] > 1.0


def test_without_stretch_the_body_keeps_its_length() -> None:
    rigid = FIRST * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    soft = rigid + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    for torques in TORQUES:
        tip, shorter = markers(rigid, torques)[-1], markers(soft, torques)[-1]
        assert np.linalg.norm(tip) <= 0.368 + 1e-9
        assert not np.allclose(tip, shorter)


def test_an_array_of_another_shape_is_named(tmp_path: Path) -> None:
    (path := tmp_path / FILE).parent.mkdir(parents=True)
    np.save(path, np.zeros((22, 4, 2)))
    with pytest.raises(DataError, match=r"\(22, 4, 2\) is not \(22, 4, 3\)"):
        rows(TENTACLE, tmp_path)
