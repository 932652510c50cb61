"""One grammar of tables (docs/tables.md), read alike through every door: function, route, command, import."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import DataError
from controller.reference.path_file import read_samples
from controller.research.identification.tables import read_measured
from recordings.read.reader import read_rows
from recordings.store.store import Store
from server.cli.main import app
from server.drawing.imported import imported
from server.drawing.messages import POINTS_MAX, ImportChoices, ImportedPath
from tests.server.live_server import TestServer

T = np.array([0.0, 0.5, 1.0, 1.5])
P = np.array([(0.03, 0.14), (0.03, 0.15), (0.04, 0.15), (0.04, 0.14)])
SI = "t,x,y\n0,0.03,0.14\n0.5,0.03,0.15\n1,0.04,0.15\n1.5,0.04,0.14\n"
SAME = {
    "t in ms": "t [ms],x_m,y_m\n0,0.03,0.14\n500,0.03,0.15\n1000,0.04,0.15\n1500,0.04,0.14\n",
    "each in its unit": "time_us;x (cm);y/mm\n0;3;140\n500000;3;150\n1000000;4;150\n1500000;4;140\n",
    "another order": "y,label,x,t\n0.14,a,0.03,0\n0.15,,0.03,0.5\n0.15,c,0.04,1\n0.14,d,0.04,1.5\n",
    "decimal commas": "t;x;y\n0;0,03;0,14\n0,5;0,03;0,15\n1;0,04;0,15\n1,5;0,04;0,14\n",
    "blanks": "# a tablet's\nt [s] y [cm]  x [cm]\n0 14 3\n0.5 15 3\n1 15 4\n1.5 14 4\n",
    "quoted cells and commas": '"t","x_m","y_m"\r\n"0","0,03","0,14"\r\n"0,5","0,03","0,15"\r\n'
    '"1","0,04","0,15"\r\n"1,5","0,04","0,14"\r\n',
    "decimal commas between tabs": "t\tx\ty\n0\t0,03\t0,14\n0,5\t0,03\t0,15\n1\t0,04\t0,15\n1,5\t0,04\t0,14\n",
    "a byte order mark": "\ufefft,x,y,\n0,0.03,0.14,\n0.5,0.03,0.15,\n1,0.04,0.15,\n1.5,0.04,0.14,\n",
    "micrometres": "t [\u00b5s],x_um,y [\u03bcm]\n0,3e4,14e4\n5e5,3e4,15e4\n1e6,4e4,15e4\n15e5,4e4,14e4\n",
    "a remark of numpy's": "# Trial 7\n# t[ms] x[cm] y[mm]\n0 3 140\n500 3 150\n1000 4 150\n1500 4 140\n",
    "a remark of MATLAB's, another order": "% y,x,t\n.14,.03,0\n.15,.03,.5\n.15,.04,1\n.14,.04,1.5\n",
    "a column of numbers of rows": "#,t,x,y\n1,0,0.03,0.14\n2,0.5,0.03,0.15\n3,1,0.04,0.15\n4,1.5,0.04,0.14\n",
    "units below the names": "t,n,x,y\n(s),,[mm],[mm]\n0,a,30,140\n0.5,b,30,150\n1,c,40,150\n1.5,d,40,140\n",
    "another delimiter in quotes": 't,x,y,"a; b"\n0,.03,.14,a\n.5,.03,.15,b\n1,.04,.15,c\n1.5,.04,.14,d\n',
    "three decimals each": "t_ms;x_mm;y_mm\n0;30.000;140.000\n500;30.000;150.000\n"
    "1000;40.000;150.000\n1500;40.000;140.000\n",
    "tabs, no header": "0\t0.03\t0.14\n0.5\t0.03\t0.15\n1\t0.04\t0.15\n1.5\t0.04\t0.14\n",
}
"""Ways to write the path SI."""
WRONG = {
    "an empty cell": ("t,x,y\n0,0.1,0.2\n1,,0.2\n", "line 3: x is empty"),
    "an empty last cell": ("10,20,\n11,21,\n", "line 1: y is empty"),
    "nan": ("t,x,y\n0,0.1,0.2\n1,nan,0.2\n", "line 3: x = nan is not finite"),
    "nan alone": ("nan,nan,nan\n1,0.1,0.2\n", "line 1: t = nan is not finite"),
    "too large": ("t,x,y\n0,0.1,1e999\n1,0.1,0.2\n", "line 2: y = 1e999 is not finite"),
    "a word": ("t,x,y\n0,0.1,0.2\n1,one,0.2\n", "line 3: x = 'one' is not a number"),
    "Python's own": ("t,x,y\n0,0.1,0.2\n1,1_0,0.2\n", "line 3: x = '1_0' is not a number"),
    "a short row": ("t,x,y\n0,0.1,0.2\n1,0.1\n", "line 3: 2 values, but y is column 3"),
    "a long row": ("t,x,y\n0,0.1,0.2\n1,0.1,0.2,7\n", "line 3: 4 values, the header has 3 columns: '7' is in none"),
    "a short row of another column": ("t,x,y,note\n0,0.1,0.2,a\n1,0.1,0.2\n", "line 3: 3 values, but note is column 4"),
    "an unknown unit": (
        "t,x [ft],y\n0,1,2\n1,1,2\n",
        "line 1: column 'x [ft]' has an unknown unit (known for x: m, cm, mm, um, in)",
    ),
    "a speed": ("t,x [mm/s],y\n0,1,2\n1,1,2\n", "column 'x [mm/s]' has an unknown unit"),
    "minutes": ("t (min),x,y\n0,1,2\n1,1,2\n", "column 't (min)' has an unknown unit (known for t: s, ms, us, ns)"),
    "a column twice": ("t,x,x_mm,y\n0,1,1000,2\n1,1,1000,2\n", "names x twice ('x' and 'x_mm')"),
    "no y": ("t,x,z\n0,1,2\n1,1,2\n", "column y is missing (the header has t, x, z)"),
    "other names": ("a,b,c\n0,1,2\n1,1,2\n", "is missing (the header has a, b, c)"),
    "four columns": ("0,1,2,3\n1,1,2,3\n", "has no header and 4 columns: "),
    "decimal commas between commas": ("0,5,0,1,0,2\n1,5,0,1,0,2\n", "has no header and 6 columns: "),
    "commas that may part thousands": (
        "t\tx [mm]\ty [mm]\n0\t1,234\t0\n1\t0\t0\n",
        "line 2: x [mm] = '1,234' may be thousands or have a decimal comma",
    ),
    "quoted commas that may part thousands": (
        't,x,y\n0,"1,234","2,345"\n1,5,6\n',
        "line 2: x = '1,234' may be thousands or have a decimal comma",
    ),
    "thousands and a point": ("t;x;y\n0;1.234,5;0\n1;0;0\n", "line 2: x = '1.234,5' is not a number"),
    "inches, or an input": ("t,x_in,y_in\n0,1,2\n1,1,2\n", "column 'x_in' has an unknown unit"),
    "a unit twice": ("t_s,x_mm,y_mm\ns,mm,mm\n0,1,2\n1,1,3\n", "line 2: t_s = 's' is not a number"),
    "an unknown unit below the names": ("t,x,y\n[s],[px],[px]\n0,1,2\n", "line 2: t = '[s]' is not a number"),
    "a lost number in the first column": ("t,x,y\n0,1,2\n#N/A,1,3\n1,1,4\n", "line 3: t = '#N/A' is not a number"),
    "a lost row": ("t;x;y\n0;1;2\n#NV;#NV;#NV\n1;1;4\n", "line 3: t = '#NV' is not a number"),
    "a row in German": ("t;x;y\n0;1;2\n#WERT!;1;3\n1;1;4\n", "line 3: t = '#WERT!' is not a number"),
    "a column too narrow": ("t\tx\ty\n0\t1\t2\n####\t1\t3\n1\t1\t4\n", "line 3: t = '####' is not a number"),
    "points that may part thousands": (
        "t;x_um;y_um\n0;998;140.000\n1;1.002;150.000\n",
        "line 2: y_um = '140.000' may be thousands or have a decimal point: write thousands without it",
    ),
    "commas between semicolons that may part thousands": (
        "t;x_um;y_um\n0;998;140,000\n1;1,002;150,000\n",
        "line 2: y_um = '140,000' may be thousands or have a decimal comma: write thousands without it",
    ),
    "blanks that part thousands": (
        "t x y\n0 1\u00a0234 5\n1 1\u00a0235 5\n",
        "line 2: x = '1\\xa0234' is not a number",
    ),
    "columns that are counted": (
        "0,1,2\n0.0,0.03,0.14\n0.5,0.03,0.15\n",
        "line 1: 0, 1, 2 may be the numbers of the columns or the first row: name the columns, or write decimals",
    ),
    "an open quote": ('t,x,y\n0,1,"2\n1,1,3\n', "line 2: a quote is not closed in this line"),
    "a cell over two lines": (
        't,x,y,note\n0,1,2,"a\n0.5,7,7,b"\n1,1,3,c\n',
        "line 2: a quote is not closed in this line: cells may not go over several",
    ),
    "a title over two lines": ('"t\n[s]","x\n[m]","y\n[m]"\n0,1,2\n1,1,3\n', "line 1: a quote is not closed"),
    "another delimiter below": (
        "t,x,y\n0;1;2\n1;1;3\n",
        "line 2: one value, '0;1;2', between commas as in the first line, but x is column 2",
    ),
    "units in a second remark": ("# t x y\n# s mm mm\n0 1 2\n1 1 3\n", "line 2: is this a remark or units? They stand"),
    "lines before the header": ("Trial seven\nt,x,y\n0,1,2\n1,1,3\n", "is missing (the header has Trial, seven)"),
    "a header with a number": ("t,x,y,3\n0,1,2,3\n1,1,3,3\n", "line 1 has no header and 4 columns"),
    "a delimiter too many": ("t,x,y\n0,1,2,\n1,1,3,\n", "line 2: 4 values, the header has 3 columns: '' is in none"),
    "pipes": ("t|x|y\n0|1|2\n", "is missing (the header has t|x|y)"),
    "JSON": ('[{"t": 0, "x": 1, "y": 2}]', "is JSON, not a table of numbers in text: save it as CSV in UTF-8"),
    "a page": ("<html><body>404</body></html>", "is XML or HTML, not a table"),
    "comma and point": (
        "t;x;y\n0;0.1;0.2\n1;0.1;1,234\n",
        "line 3: y = '1,234' has a decimal comma, but a point is in line 2: x = '0.1'",
    ),
    "a falling time": ("t [ms],x,y\n500,0,0\n400,0,0\n", "line 3: t = 0.4 s is not after 0.5 s of line 2"),
    "one row": ("t,x,y\n0,0.1,0.2\n", "a path needs at least 2 rows of numbers, there are 1"),
    "no row": ("# nothing\n", "is empty: columns t, x, y are needed"),
    "too far": ("t,x_m,y_m\n0,0,0\n1,0,2e3\n", "line 3: y = 2000 m, more than 1000"),
}
"""Files that hold no path, and what is said of each."""
MEASURED_WRONG = {
    "an empty cell": ("p1,x1,y1\n1,2,\n", "line 2: y1 is empty"),
    "an infinite cell": ("ID,x1,y1\n1,2,inf\n", "line 2: y1 = inf is not finite"),
    "a long row": ("p1,x1\n1,2,3\n", "line 2: 3 values, the header has 2 columns: '3' is in none"),
    "an unknown unit": (
        "p1 [atm],x1,y1\n1,2,3\n",
        "column 'p1 [atm]' has an unknown unit (known for p1: pa, kpa, mpa, mbar, bar, psi)",
    ),
    "an unknown unit beside a known one": ("x1_feet,x1,p1\n1,2,3\n", "column 'x1_feet' has an unknown unit"),
    "a column twice": ("p1,x1,x1_mm\n1,2,3\n", "names x1 twice ('x1' and 'x1_mm')"),
    "no header": ("1,2,3\n", "has no header and 3 columns: a header is needed"),
    "a lost number": ("p1,x1\n1,2\n#REF!,2\n", "line 3: p1 = '#REF!' is not a number"),
    "a unit of one pressure": ("p1 [kPa],p2,x1\n1,2,3\n", "column p2 names no unit, but p1 [kPa] is in kpa"),
}
Door = Callable[[str], object]


def written(folder: Path, text: str) -> Path:
    file = folder / "path.csv"
    file.write_text(text)
    return file


def run(*arguments: object) -> None:
    app([str(one) for one in arguments], standalone_mode=False)


@pytest.fixture(params=["function", "page", "track", "recordings import"])
def file_door(request: pytest.FixtureRequest, tmp_path: Path) -> Door:
    """What takes a text, without a server."""
    doors: dict[str, Door] = {
        "function": lambda text: read_samples(written(tmp_path, text)),
        "page": lambda text: imported(text.encode(), ImportChoices(name="path.csv")),
        "track": lambda text: run("track", "--reference", written(tmp_path, text)),
        "recordings import": lambda text: run("recordings", "import", written(tmp_path, text), "--folder", tmp_path),
    }
    return doors[request.param]


@pytest.mark.parametrize(("text", "words"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_refused_at_every_door_with_line_column_and_value(
    text: str, words: str, file_door: Door
) -> None:
    with pytest.raises(DataError) as caught:
        file_door(text)
    assert words in str(caught.value) and "path.csv" in str(caught.value)


def test_the_routes_refuse_the_same_in_the_same_words(server: TestServer) -> None:
    doors = (
        (server.page().sign_in(), "/api/drawings/import", "path.csv"),
        (server.operator(), "/api/recordings/import", "the file"),
    )
    for page, path, name in doors:  # a session each: together they send more at once than one may
        for text, words in WRONG.values():
            answer = page.post(path, params={"name": "path.csv"}, content=text)
            assert answer.status_code == 422, (path, text, answer.text)
            assert words in answer.json()["detail"] and name in answer.json()["detail"]


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_the_same_path_is_read_from_every_way_to_write_it(text: str, tmp_path: Path) -> None:
    samples = read_samples(written(tmp_path, text))
    page = imported(text.encode(), ImportChoices(name="path.csv"))
    run("recordings", "import", written(tmp_path, text), "--folder", tmp_path)
    (kept,) = Store(tmp_path).list()
    rows = read_rows(Store(tmp_path).path(kept.id))
    for t, p in (
        (samples.t, samples.p),
        (page.times, page.points),
        (rows["t_ns"] * 1e-9, rows["p_meas"]),
    ):
        np.testing.assert_allclose(t, T, rtol=1e-12)
        np.testing.assert_allclose(p, P, rtol=1e-12)


@pytest.mark.parametrize("name", ["t in ms", "each in its unit", "another order"])
def test_the_same_path_is_tracked_from_every_way_to_write_it(name: str, tmp_path: Path) -> None:
    told = []
    for text in (SI, SAME[name]):
        run("track", "--reference", written(tmp_path, text), "--json", tmp_path / "figures.json")
        told.append(json.loads((tmp_path / "figures.json").read_text())["reference"])
    for fact in ("duration", "length", "peak_speed", "approach"):
        assert told[1][fact] == pytest.approx(told[0][fact], rel=1e-9), fact


@pytest.mark.parametrize(("text", "words"), MEASURED_WRONG.values(), ids=MEASURED_WRONG)
def test_measured_data_are_refused_in_the_same_words(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(DataError) as caught:
        run("identify", written(tmp_path, text), "--out", tmp_path / "mine.toml")
    assert words in str(caught.value) and "path.csv" in str(caught.value)


def test_measured_data_may_be_in_all_units_of_the_grammar(tmp_path: Path) -> None:
    table = read_measured(written(tmp_path, "y1 [cm];Time (ms);P1/kPa;x1_mm\n1,5;20;3;4\n"))
    found = {name: float(values[0]) for name, values in table.columns.items()}
    assert found == pytest.approx({"y1": 0.015, "t": 0.02, "p1": 3e3, "x1": 4e-3})


def noted(text: str) -> ImportedPath:
    return imported(text.encode(), ImportChoices(name="path.csv"))


@pytest.mark.parametrize(
    ("text", "points", "notes"),
    [
        (
            "x,y\n0.1,0.2\n0.1,0.1\n",
            [(0.1, 0.2), (0.1, 0.1)],
            ["x has no unit: taken as m", "y has no unit: taken as m"],
        ),
        (
            "100 50\n1 2\n",
            [(0.1, 0.05), (1e-3, 2e-3)],
            [
                "no header: the columns are x, y",
                "x has no unit: taken as mm, as some values are beyond 2",
                "y has no unit: taken as mm, as some values are beyond 2",
            ],
        ),
        ("y,x_cm\n1,1\n2,1\n", [(0.01, 0.01), (0.01, 0.02)], ["y has no unit: taken as cm, as the other axis"]),
        ("x_m,n,y_m\n1,a,1\n1,b,1.5\n", [(1.0, 1.0), (1.0, 1.5)], ["not used: n"]),
        ("x_m,y_m\n3,1\n1,1.5\n", [(3.0, 1.0), (1.0, 1.5)], []),
    ],
)
def test_the_page_is_told_what_the_file_does_not_say(text: str, points: list[Any], notes: list[str]) -> None:
    found = noted(text)
    assert found.times is None
    np.testing.assert_allclose(found.points, points, rtol=1e-12)
    assert found.notes == notes


@pytest.mark.parametrize("text", ["t,x_mm,y\n0,1,2\n1,1,3\n", "t,y,x [cm]\n0,1,2\n1,1,3\n"])
def test_a_unit_of_one_axis_is_not_taken_for_si_on_the_other(text: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"line 1: column y names no unit, but x.*write it behind the name, as in y"):
        read_samples(written(tmp_path, text))
    assert "y has no unit: taken as" in noted(text).notes[1] and "as the other axis" in noted(text).notes[1]


def test_what_a_file_leaves_open_is_said_at_every_door(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "n,t,x,y\n" + "".join(f"1,{t},0.03,{0.14 + 0.001 * t}\n" for t in (0, 1, 2, 3, 30))
    said = ["t has no unit: taken as s", "y has no unit: taken as m", "not used: n", "gap of 27 s before line 6"]
    run("recordings", "import", written(tmp_path, text), "--folder", tmp_path)
    for door in (
        capsys.readouterr().out,
        "; ".join(noted(text).notes),
        "; ".join(read_samples(tmp_path / "path.csv").notes),
    ):
        assert [words for words in said if words not in door] == []


def test_times_begin_with_the_first_row_and_columns_are_told_as_they_were_understood() -> None:
    found = noted("y [mm],t,x [mm]\n1,5,2\n2,6.5,2\n")
    assert found.times == [0.0, 1.5]
    assert [(one.name, one.title, one.unit, one.stated) for one in found.columns] == [
        ("t", "t", "s", False),
        ("x", "x [mm]", "mm", True),
        ("y", "y [mm]", "mm", True),
    ]
    assert found.notes == ["t has no unit: taken as s"]


def test_a_time_that_cannot_be_read_is_not_left_out_in_silence() -> None:
    with pytest.raises(DataError, match=r"column 't \[min\]' has an unknown unit"):
        noted("x,y,t [min]\n0,0,0\n1,1,1\n")


def test_a_long_path_is_thinned_evenly_to_what_a_drawing_holds() -> None:
    found = noted("t_s,x_m,y_m\n" + "".join(f"{n},{n * 1e-4:.4f},0\n" for n in range(9999)))
    assert found.times is not None and len(found.points) == len(found.times) == POINTS_MAX
    assert (found.times[0], found.times[-1]) == (0.0, 9998.0)
    assert set(np.diff(found.times)) == {2.0}
    assert found.notes == [f"thinned from 9999 points to {POINTS_MAX}"]


def test_a_viewer_may_have_a_file_read_and_one_that_is_too_large_is_refused(server: TestServer) -> None:
    viewer = server.page().sign_in()
    answer = viewer.post("/api/drawings/import", params={"name": "a.csv"}, content="t_ms,x_mm,y_mm\n0,1,2\n500,2,2\n")
    assert answer.status_code == 200, answer.text
    assert answer.json()["times"] == [0.0, 0.5] and answer.json()["points"] == [[1e-3, 2e-3], [2e-3, 2e-3]]
    assert viewer.get("/api/drawings").json() == []
    large = viewer.post("/api/drawings/import", content=b"0,1,2\n" * 200_000)
    assert large.status_code == 413 and "1048576" in large.text
