"""Hidden tags of a limb, from two that are seen: on limbs that we bend, whose every point is known."""

import csv
from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.shape import estimated, resting_body
from controller.research.measured.limb import AT_REST, FILE, HIDDEN, LIMB, SCATTER, SEEN, TAGS
from controller.research.measured.sets import rows

pytestmark = pytest.mark.keyed()

RODS, LENGTH = 80, 540.0


def bent(proximal: float, distal: float, stretch: float = 0.0, force: float = 0.0) -> Array:
    """Tags (9,2) [pixels] of a limb with a bend of its own, whose halves bend by so much more, as does a tip's load."""
    even = np.where(np.arange(RODS) < RODS // 2, proximal, distal) / (RODS // 2)
    theta = 0.2 + np.cumsum(even + (1.0 + 2.0 * force) / RODS * np.linspace(1.0, 0.0, RODS))
    h = LENGTH / RODS * (1.0 + stretch)
    ends = np.vstack([np.zeros(2), np.cumsum(h * np.column_stack([np.cos(theta), np.sin(theta)]), axis=0)])
    return np.asarray(40.0 + ends[:: RODS // 8])


def written(path: Path, frames: list[Array], lost: int = 0) -> Path:
    """A table as the limb's, with `lost` frames before in which no tag was found."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["Test time", *(f"tagid_{axis}_{tag}" for tag in TAGS for axis in "xy")])
        out.writerows([0.0] * (1 + 2 * len(TAGS)) for _ in range(lost))
        out.writerows([0.2 * n, *frame.ravel()] for n, frame in enumerate(frames))
    return path


def test_hidden_tags_are_where_the_halves_and_forces_put_them(tmp_path: Path) -> None:
    rest = [bent(0.0, 0.0)] * AT_REST
    moved = [bent(1.2 * s, -0.9 * s**2, 0.002 * s, 0.3 * s) for s in np.linspace(-1.0, 1.0, 21)]
    written(tmp_path / "dismech-rods" / FILE, [*rest, *moved], lost=3)
    (row,) = rows(LIMB, tmp_path)
    assert row["ours"] is not None
    assert row["ours"] < 0.35
    assert row["ours"] < 0.3 * row["baselines"]["cubic"]
    assert row["baselines"]["chords"] > 1.0


def test_what_is_hidden_is_not_looked_at() -> None:
    body = resting_body(bent(0.0, 0.0) / LENGTH, halves=SEEN[0])
    seen = (bent(0.6, 0.3) - bent(0.6, 0.3)[0])[list(SEEN)] / LENGTH
    places, bends = estimated(body, SEEN, seen, SCATTER)
    assert len(seen) + len(HIDDEN) == len(TAGS) - 1
    assert bends == pytest.approx([0.6, 0.3], abs=0.04)
    assert places[list(SEEN)] == pytest.approx(seen, abs=5e-4)


@pytest.mark.parametrize(
    ("text", "said"),
    [("Test time,tagid_x_101\n0,1\n", "tagid_y_101"), ("", "frames"), ("\0\xff", "tags")],
    ids=["columns", "empty", "garbage"],
)
def test_a_table_of_something_else_is_named(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / FILE
    path.parent.mkdir(parents=True)
    path.write_text(text)
    with pytest.raises(DataError, match=said) as error:
        rows(LIMB, tmp_path)
    assert str(path) in str(error.value)
