"""What is said of a file before it is imported on the page: as it is meant, or what is wrong with line and column."""

from typing import Any

import numpy as np
import pytest

from controller.errors import DataError
from server.drawing.imported import proposed
from server.drawing.messages import POINTS_MAX, ImportChoices, ImportProposal
from tests.server.live_server import TestServer

P = [(0.03, 0.14), (0.03, 0.15), (0.04, 0.15)]
T = [0.0, 0.5, 1.0]
Meaning = tuple[str | None, str | None, bool]


def read(text: str | bytes, **choices: Any) -> ImportProposal:
    sent = text if isinstance(text, bytes) else text.encode()
    return proposed(sent, ImportChoices(name="path.csv", **choices))


MEANT: dict[str, tuple[str, dict[str, Any], list[Meaning]]] = {
    "all is said": (
        "y (mm);note;t_ms;x [mm]\n140;a;0;30\n150;;500;30\n150;c;1000;40\n",
        {},
        [("y", "mm", True), (None, None, False), ("t", "ms", True), ("x", "mm", True)],
    ),
    "units are not said": (
        "t,x,y\n0,3,14\n0.5,3,15\n1,4,15\n",
        {"length_unit": "cm", "time_unit": "s"},
        [("t", "s", False), ("x", "cm", False), ("y", "cm", False)],
    ),
    "no header": (
        "0 30 140\n500 30 150\n1000 40 150\n",
        {"length_unit": "mm", "time_unit": "ms"},
        [("t", "ms", False), ("x", "mm", False), ("y", "mm", False)],
    ),
    "no header, another order": (
        "140 30 0\n150 30 500\n150 40 1000\n",
        {"x": 2, "y": 1, "t": 3, "length_unit": "mm", "time_unit": "ms"},
        [("y", "mm", False), ("x", "mm", False), ("t", "ms", False)],
    ),
    "no header, more columns": (
        "7,0,.03,.14\n8,.5,.03,.15\n9,1,.04,.15\n",
        {"x": 3, "y": 4, "t": 2, "length_unit": "m", "time_unit": "s"},
        [(None, None, False), ("t", "s", False), ("x", "m", False), ("y", "m", False)],
    ),
    "other names with units": (
        "clock [s],tip_x_mm,tip_y (cm),x,y\n0,30,14,1,1\n0.5,30,15,1,1\n1,40,15,1,1\n",
        {"x": 2, "y": 3, "t": 1},
        [("t", "s", True), ("x", "mm", True), ("y", "cm", True), (None, None, False), (None, None, False)],
    ),
    "an unknown unit that a person knows": (
        "t_s,x [px],y [px]\n0,3,14\n.5,3,15\n1,4,15\n",
        {"x": 2, "y": 3, "length_unit": "cm"},
        [("t", "s", True), ("x", "cm", False), ("y", "cm", False)],
    ),
}


@pytest.mark.parametrize(("text", "choices", "meanings"), MEANT.values(), ids=MEANT)
def test_a_file_is_read_as_its_header_and_a_person_say(
    text: str, choices: dict[str, Any], meanings: list[Meaning]
) -> None:
    found = read(text, **choices)
    assert [(one.name, one.unit, one.stated) for one in found.columns] == meanings
    assert found.problem == "" and found.times_problem == "" and found.count == 3
    assert found.path is not None
    assert [note for note in found.path.notes if "taken as" in note] == []
    np.testing.assert_allclose(found.path.points, P, rtol=1e-12)
    np.testing.assert_allclose(found.path.times or [], T, rtol=1e-12)
    np.testing.assert_allclose([row.point or () for row in found.rows], P, rtol=1e-12)
    assert [row.t for row in found.rows] == T


def test_inches_are_understood_and_a_time_that_is_not_wanted_is_left_out() -> None:
    found = read("t,x [in],y/inch\n5,1,2\n5,2,2\n", t=0)
    assert found.path is not None and found.path.times is None
    np.testing.assert_allclose(found.path.points, [(0.0254, 0.0508), (0.0508, 0.0508)])
    assert [one.name for one in found.columns] == [None, "x", "y"]


WRONG: dict[str, tuple[str, dict[str, Any], str]] = {
    "an empty cell": ("x,y\n1,2\n,3\n", {}, "line 3: x is empty"),
    "an empty cell of a chosen column": ("a,b\n1,2\n3,\n", {"x": 1, "y": 2}, "line 3: b is empty"),
    "other names": ("a,b\n1,2\n3,4\n", {}, "line 1: column x is missing (the header has a, b)"),
    "four columns": ("1,2,3,4\n", {}, "line 1 has no header and 4 columns"),
    "a column that is not wanted": ("x,y\n1,2\n3,4\n", {"y": 0}, "line 1: column y is missing"),
    "a ragged row": ("t,x,y\n0,1,2\n1,2\n", {}, "line 3: 2 values, but y is column 3"),
    "a time that stays": ("t,x,y\n0,1,2\n0,2,2\n", {}, "line 3: t = 0 s is not after 0 s of line 2"),
    "one point": ("x,y\n1,2\n1,2\n", {}, "all 2 rows are at x = 1 m, y = 2 m, which is no path"),
    "a header only": ("t,x,y\n", {}, "a path needs at least 2 rows of numbers, there are 0"),
}


@pytest.mark.parametrize(("text", "choices", "words"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_said_beside_columns_and_first_rows(text: str, choices: dict[str, Any], words: str) -> None:
    found = read(text, **choices)
    assert words in found.problem
    assert found.path is None and found.count == 0
    assert found.columns and all(row.point is None for row in found.rows)
    first = text.splitlines()[1 if found.header else 0 :]
    assert [row.cells for row in found.rows] == [line.split(",") for line in first]


def test_columns_that_cannot_be_meant_are_refused() -> None:
    with pytest.raises(DataError, match="x = column 3, but there are 2 columns"):
        read("x,y\n1,2\n3,4\n", x=3)
    with pytest.raises(DataError, match="x = column 1, y = column 1: each must be a column of its own"):
        read("a,b\n1,2\n3,4\n", x=1, y=1)


@pytest.mark.parametrize(
    ("sent", "words"),
    [
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "path.csv is a PNG picture, not a table of numbers in text"),
        (b"PK\x03\x04\x14\0\x06\0", "path.csv is an archive, as .xlsx and .ods files are, not a table"),
        (b' {"x": [1, 2]}', "path.csv is JSON, not a table"),
        (
            "t,x,y\n0,1,2\n".encode("utf-16"),
            "path.csv is text in UTF-16, not a table of numbers in text: save it as CSV",
        ),
        ("t,x,y\n0,1,2\n".encode("utf-16-le"), "path.csv, line 1: a zero byte, which is no text"),
        ("x [µm],y\n1,2\n".encode("latin-1"), "path.csv, line 1: byte 0xb5 is not UTF-8: save it as CSV in UTF-8"),
        (b"", "path.csv is empty"),
        (b"# only a remark\n\n", "path.csv is empty"),
    ],
)
def test_what_is_no_table_is_refused_by_its_kind(sent: bytes, words: str) -> None:
    with pytest.raises(DataError) as caught:
        read(sent)
    assert words in str(caught.value)


def test_a_remark_in_another_encoding_does_no_harm() -> None:
    found = read("# Größe\nx_mm,y_mm\n1,2\n3,4\n".encode("latin-1"))
    assert found.problem == "" and [row.line for row in found.rows] == [3, 4]


def test_times_that_a_drawing_cannot_keep_are_said_and_a_long_file_is_thinned() -> None:
    rows = "".join(f"{n},{n * 1e-4:.4f},0\n" for n in range(9999))
    found = read("t_s,x_m,y_m\n" + rows)
    assert found.times_problem == "the file lasts 9998 s, a drawing 0.1 to 280 s"
    assert found.count == 9999 and found.path is not None and len(found.path.points) == POINTS_MAX
    assert found.path.notes == [f"thinned from 9999 points to {POINTS_MAX}"]
    assert len(found.rows) == 5 and found.rows[4].point == (4e-4, 0.0), "the first rows of the file, not of the picture"


def test_a_viewer_has_a_file_proposed_by_the_server_which_keeps_nothing(server: TestServer) -> None:
    viewer = server.page().sign_in()
    asked = {"name": "a.csv", "x": 1, "y": 2, "t": 0, "length_unit": "in"}
    answer = viewer.post("/api/drawings/import/proposal", params=asked, content="a,b\n1,2\n3,4\n")
    assert answer.status_code == 200, answer.text
    assert answer.json()["path"]["points"] == [pytest.approx((0.0254, 0.0508)), pytest.approx((0.0762, 0.1016))]
    assert viewer.get("/api/drawings").json() == []
    refused = viewer.post("/api/drawings/import/proposal", params=asked, content=b"\x89PNG\r\n")
    assert refused.status_code == 422 and "a.csv is a PNG picture" in refused.json()["detail"]
    wrong = viewer.post("/api/drawings/import/proposal", params={"length_unit": "ft"}, content="x,y\n1,2\n3,4\n")
    assert wrong.status_code == 422 and "length_unit" in wrong.text
