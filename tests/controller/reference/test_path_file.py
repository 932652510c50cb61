"""What people have in their files, and what is wrong in some of them."""

import os
from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError
from controller.reference.path_file import read_samples


def written(folder: Path, text: str) -> Path:
    file = folder / "path.csv"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    "text",
    [
        "t,x,y\n5,0.1,0.2\n5.5,0.11,0.21\n",
        "5,0.1,0.2\n5.5,0.11,0.21\n",
        "\ufefft,x,y\r\n5,0.1,0.2\r\n5.5,0.11,0.21\r\n",
        "# from a tablet\n\nY [mm], label ,time (ms),x_cm,speed_mps\n200,a,5000,10,0\n210,b,5500,11,\n",
        "t;x;y\n5,0;0,1;0,2\n5,5;0,11;0,21\n",
        "t\tx\ty\n5\t0.1\t0.2\n5.5\t0.11\t0.21\n",
        '# t x y\n5 0.1 0.2\n5.5  0.11 "0.21"\n'.replace('"', ""),
        '"t","x","y","note"\n5,0.1,0.2,"a, b"\n5.5,0.11,0.21,\n',
        "t,x,y,x_dot,y_dot,time_stamp\n5,0.1,0.2,0,0,7\n5.5,0.11,0.21,0,0,7\n",
        "x_feet,t,x,y\n4,5,0.1,0.2\n4,5.5,0.11,0.21\n",
        "t/s,x/m,y/m\n5.0e0,1e-1,.2\n5.5,0.11,+0.21\n",
    ],
)
def test_columns_are_read_by_name_in_their_units_whatever_the_file_is_like(tmp_path: Path, text: str) -> None:
    samples = read_samples(written(tmp_path, text))
    np.testing.assert_allclose(samples.t, [5.0, 5.5], rtol=1e-15)
    np.testing.assert_allclose(samples.p, [[0.1, 0.2], [0.11, 0.21]], rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "is empty: columns t, x, y are needed"),
        ("# only this\n", "is empty"),
        ("t,x,y\n", "a path needs at least 2 rows of numbers, there are 0"),
        ("t,x,y\n0,0.1,0.2\n", "at least 2 rows of numbers, there are 1"),
        ("t,x\n0,0.1\n", r"column y is missing \(the header has t, x\)"),
        ("a,b,c\n0,0.1,0.2\n", r"column t is missing \(the header has a, b, c\)"),
        ("0,0.1,0.2,7\n1,0.1,0.2,7\n", r"no header and 4 columns: three \(t, x, y\) are needed"),
        ("t,x,y\n0,0.1,0.2\n0.1,,0.2\n", "line 3: x is empty"),
        ("t,x,y\n0,0.1,0.2\n0.1,nan,0.2\n", "line 3: x = nan is not finite"),
        ("nan,0.1,0.2\n0.1,0.1,0.2\n", "line 1: t = nan is not finite"),
        ("t,x,y\n0,0.1,0.2\n0.1,0.1,two\n", "line 3: y = 'two' is not a number"),
        ("t,x,y\n0,0.1,0.2\n0.1,0.1\n", "line 3: 2 values, but y is column 3"),
        ("t,x,y\n0,0.1,0.2\n0.1,0.1,0.2\n0.1,0.1,0.2\n", "line 4: t = 0.1 s is not after 0.1 s of line 3"),
        ("t_ms,x,y\n20,0.1,0.2\n10,0.1,0.2\n", "line 3: t = 0.01 s is not after 0.02 s of line 2"),
        ("t,x_feet,y\n0,1,2\n", r"line 1: column 'x_feet' has an unknown unit \(known for x: m, cm, mm, um, in\)"),
        ("t,x,x_mm,y\n0,1,1000,2\n", r"names x twice \('x' and 'x_mm'\)"),
    ],
)
def test_what_is_wrong_is_said_with_file_line_column_and_value(tmp_path: Path, text: str, complaint: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(DataError, match=complaint) as caught:
        read_samples(file)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize("header", ["t,x,y\n", ""])
def test_a_pipe_is_read_as_a_file_is(header: str) -> None:
    end, other = os.pipe()
    os.write(other, f"{header}5,0.1,0.2\n5.5,0.11,0.21\n".encode())
    os.close(other)
    samples = read_samples(Path(f"/dev/fd/{end}"))
    os.close(end)
    assert samples.t.tolist() == [5.0, 5.5]


def test_a_file_that_is_not_text_or_not_there_is_said(tmp_path: Path) -> None:
    (tmp_path / "photo.csv").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff\xfe")
    for name, words in (("photo.csv", "is a PNG picture"), ("nothing.csv", "cannot be read"), (".", "cannot be read")):
        with pytest.raises(DataError, match=words):
            read_samples(tmp_path / name)
