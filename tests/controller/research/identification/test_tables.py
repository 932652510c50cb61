from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError
from controller.research.identification.tables import choose_ids, points_in, read_measured

pytestmark = pytest.mark.keyed()


def written(folder: Path, text: str) -> Path:
    file = folder / "data.csv"
    file.write_text(text)
    return file


def test_columns_come_by_name_in_si_units_whatever_their_order(tmp_path: Path) -> None:
    table = read_measured(
        written(tmp_path, "# poses of May\nY1_mm,p1_kPa,p2 [Pa],X1_m\n20,50,1e3,0.1\n\n30,60,0,0.2\n")
    )
    assert table.need("p1") == pytest.approx([50e3, 60e3])
    assert table.need("p2") == pytest.approx([1e3, 0.0])
    np.testing.assert_allclose(points_in(table, "xy"), [[[0.1, 0.02]], [[0.2, 0.03]]])
    assert list(table.lines) == [3, 5]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "is empty"),
        ("p1,p2,x1\n1,2,3\n", "column y1 is missing"),
        ("p1,p2,x2,y2\n1,2,3,4\n", "column x1 is missing"),
        ("x1,y1\n1,2\n1,nan\n", "line 3: y1 = nan is not finite"),
        ("x1,y1\n1,2\n1,two\n", "line 3: y1 = 'two' is not a number"),
        ("x1,y1\n1,2,3\n", "line 2: 3 values, the header has 2 columns"),
        ("x1,x1\n1,2\n", "the header names x1 twice ('x1' and 'x1')"),
        ("x1_feet,y1\n1,2\n", "'x1_feet' has an unknown unit"),
        ("x1_kpa,y1\n1,2\n", "'x1_kpa' has an unknown unit (known for x1: m, cm, mm, um, in)"),
        ("x1,y1,\n1,2,\n", "column '' has no name"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_with_file_line_column_and_value(
    tmp_path: Path, text: str, complaint: str
) -> None:
    file = written(tmp_path, text)
    with pytest.raises(DataError) as caught:
        points_in(read_measured(file), "xy")
    assert str(file) in str(caught.value) and complaint in str(caught.value)


def test_a_file_that_is_not_there_is_said_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="cannot be read"):
        read_measured(tmp_path / "nothing.csv")


@pytest.mark.parametrize(
    ("text", "chosen"), [(None, [0, 2, 4, 6, 20]), ("0-4", [0, 2, 4]), ("20, 1-2", [2, 20]), ("6", [6])]
)
def test_ids_are_chosen_singly_and_by_ranges(text: str | None, chosen: list[int]) -> None:
    assert choose_ids(text, [4, 2, 2, 0, 6, 20], Path("data.csv")) == chosen


@pytest.mark.parametrize(
    ("text", "complaint"),
    [("3", "ID 3 is not there"), ("30-40", "IDs 0 to 6 are"), ("a", "neither"), ("", "neither"), ("6-2", "6-2 begins")],
)
def test_ids_that_are_not_there_are_named(text: str, complaint: str) -> None:
    with pytest.raises(DataError, match=complaint):
        choose_ids(text, [0, 2, 6], Path("data.csv"))
