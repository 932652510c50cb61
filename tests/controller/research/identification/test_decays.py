from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError
from controller.research.identification.motion.decays import Decay, long_ones, read_decays
from controller.research.identification.plane import body_arcs, hanging_axis, project

pytestmark = pytest.mark.keyed()


def written(folder: Path, text: str) -> Path:
    path = folder / "decays.csv"
    path.write_text(text)
    return path


def swinging(angle: float, bodies: int = 2, samples: int = 200) -> Decay:
    """Bodies that hang along -y and swing in the vertical plane at `angle` about y, with a tenth across it."""
    t = 0.01 * np.arange(samples)
    swing = np.exp(-4.0 * t) * np.cos(15.0 * t)
    plane, across = np.array([np.cos(angle), 0, np.sin(angle)]), np.array([-np.sin(angle), 0, np.cos(angle)])
    arcs = 0.1 * np.arange(1, bodies + 1)
    moved = arcs[:, None] * (plane - 0.1 * np.array([0, -1, 0])) * swing[:, None, None]
    sideways = 0.1 * arcs[:, None] * across * (np.exp(-4.0 * t) * np.sin(15.0 * t))[:, None, None]
    return Decay(0, t, moved + sideways + arcs[:, None] * np.array([0, -1, 0]) + np.array([0.3, 0, 0.2]))


def test_bodies_and_decays_are_read_in_space_at_100_hz(tmp_path: Path) -> None:
    rows = "7,1,2,3,4,5,6\n7,1,2,3,4,5,9\n8,0,0,0,0,0,0\n"
    decays = read_decays(written(tmp_path, "ID,x1_mm,y1_mm,z1_mm,x2_mm,y2_mm,z2_mm\n" + rows))
    assert [one.id for one in decays] == [7, 8]
    assert decays[0].t.tolist() == [0.0, 0.01]
    assert decays[0].points[1] == pytest.approx(1e-3 * np.array([[1, 2, 3], [4, 5, 9]]))


def test_a_time_column_and_a_plane_are_read_as_they_stand(tmp_path: Path) -> None:
    decay = read_decays(written(tmp_path, "ID,t,x1_mm,y1_mm\n1,5.0,10,20\n1,5.004,11,21\n"), "0-3")[0]
    assert decay.t == pytest.approx([0.0, 0.004])
    assert decay.points[:, 0] == pytest.approx(np.array([[0.010, 0.020], [0.011, 0.021]]))


@pytest.mark.parametrize(
    ("text", "ids", "complaint"),
    [
        ("x1,y1\n1,2\n", None, "column ID is missing"),
        ("ID,x1,y1,x2\n1,2,3,4\n", None, "column y2 is missing"),
        ("ID,x1,y1,z1,w1\n1,2,3,4,5\n", None, "column w1 is unknown"),
        ("ID,x1,y1\n1.5,2,3\n", None, r"line 2: ID = 1.5 is not whole"),
        ("ID,x1,y1\n1,2,3\n2,2,3\n1,2,3\n", None, r"line 4: ID 1 has begun further up"),
        ("ID,t,x1,y1\n1,0.1,2,3\n1,0.1,2,3\n", None, r"line 3: t = 0.1 s does not come after 0.1 s"),
        ("ID,x1,y1\n1,2,abc\n", None, r"line 2: y1 = 'abc' is not a number"),
        ("ID,x1,y1\n1,2,3\n", "4", "ID 4 is not there"),
        ("ID,x1,y1\n1,120,3\n1,90,3\n", None, r"body 1 moves by 30 m, more than 4 m: .* as in x1 \[mm\]"),
    ],
)
def test_what_is_wrong_in_decays_is_said_with_column_row_and_value(
    tmp_path: Path, text: str, ids: str | None, complaint: str
) -> None:
    with pytest.raises(DataError, match=complaint):
        read_decays(written(tmp_path, text), ids)


def test_only_decays_of_more_than_150_samples_are_taken() -> None:
    short, enough = swinging(0.0, samples=150), swinging(0.0, samples=151)
    assert long_ones([short, enough], "score", Path("data.csv")) == [enough]
    with pytest.raises(DataError, match="no decay to score has more than 150 samples"):
        long_ones([short], "score", Path("data.csv"))


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 3.0])
def test_the_main_plane_is_found_whatever_its_direction(angle: float) -> None:
    decay = swinging(angle)
    motion = project(decay, hanging_axis([decay]), 1)
    s = np.exp(-4.0 * decay.t) * np.cos(15.0 * decay.t)
    s -= s[-20:].mean()
    assert np.abs(motion.lateral - 0.1 * np.array([1, 2]) * s[:, None]).max() < 3e-3
    assert motion.outside == pytest.approx(0.1, abs=0.03)
    assert motion.moved[:, 1, 0] == pytest.approx(-0.02 * s, abs=1e-9)


def test_arcs_are_heights_below_the_clamp_at_zero_of_the_hanging_axis() -> None:
    decay = swinging(0.3, bodies=4)
    axis = hanging_axis([decay])
    assert axis.tolist() == [0.0, -1.0, 0.0]
    assert body_arcs([decay], axis) == pytest.approx([0.1, 0.2, 0.3, 0.4], abs=1e-3)
    with pytest.raises(DataError, match="body 2 rests"):
        body_arcs([Decay(0, decay.t, decay.points[:, ::-1])], axis)
    with pytest.raises(DataError, match=r"body 4 rests 400 m from the clamp, at most 2\.0 m"):
        body_arcs([Decay(0, decay.t, 1e3 * decay.points)], axis)
