"""The window as CSV, and layouts kept per browser: what a page gets, and how bad requests are refused."""

import csv
import io

import numpy as np
import pytest

from server.access.user_files import UserFiles
from server.http.who import Identity
from server.plots.layouts import LAYOUTS_MAX, Layouts
from server.plots.messages import CHANNELS_MAX, PlotLayout
from server.plots.routes import NothingKept, Table, Window, lines, table
from server.rig.history import BIN_TICKS, History
from tests.server.live_server import TestServer, wait_for
from tests.server.plots.test_history import filled, rows

LAYOUT = {"seconds": 30.0, "plots": [{"title": "energies", "channels": ["energy", "ledger"]}]}


def read(found: Table) -> tuple[str, list[str], np.ndarray]:
    """Comment, header and numbers of the CSV text."""
    text = "".join(lines(found, "test", 1.8e9)).splitlines()
    cells = list(csv.reader(io.StringIO("\n".join(text[2:]))))
    return text[0] + text[1], cells[0], np.array(cells[1:], float)


def test_a_recent_window_is_every_tick_exactly() -> None:
    history = filled(2000)
    said, names, values = read(table(history, Window(1.5, 1.6, ["tick", "p_meas.0", "energy"])))
    assert "every tick" in said
    assert "2027-01-15T08:00:01.500+00:00" in said
    assert names == ["t [s]", "tick [1]", "p_meas.0 [m]", "energy [J]"]
    assert np.array_equal(values[:, 1], np.arange(1500, 1600))
    assert np.allclose(values[:, 0], values[:, 1] * 1e-3)
    assert np.all(np.isnan(values[:, 2]))


def test_an_older_window_is_extremes_and_says_so() -> None:
    history = filled(2000, bins=110)
    said, names, values = read(table(history, Window(0.4, 1.6, ["energy"])))
    assert f"{BIN_TICKS} ticks" in said
    assert names == ["t [s]", "energy [J] low", "energy [J] high"]
    assert np.array_equal(values[:, 2] - values[:, 1], np.full(len(values), BIN_TICKS - 1))
    assert 0.4 <= values[0, 0] < 0.42
    assert 1.58 < values[-1, 0] < 1.6


def test_a_window_from_before_a_young_history_is_still_every_tick() -> None:
    assert table(filled(500), Window(-10.0, 0.1, ["energy"])).values.shape == (100, 2)


@pytest.mark.parametrize("window", [(5.0, 6.0), (0.2, 0.1), (-1e300, -1.0), (1e300, 1e301)])
def test_a_window_without_data_is_refused(window: tuple[float, float]) -> None:
    with pytest.raises(NothingKept):
        table(filled(500), Window(*window, ["energy"]))
    with pytest.raises(NothingKept):
        table(History(1000, 100), Window(*window, ["energy"]))


def test_the_route_gives_a_file_and_names_what_is_wrong(server: TestServer) -> None:
    page = server.operator()
    history = server.services.history
    wait_for(lambda: history.count > 500, "history")
    now = float(history.newest["t_ns"][0]) * 1e-9
    good = {"from": now - 0.2, "to": now, "channels": ["p_ref.0", "error.norm"]}
    answer = page.get("/api/history.csv", params=good)
    assert answer.status_code == 200
    assert "tendril-test.csv" in answer.headers["content-disposition"]
    assert len(answer.text.splitlines()) > 150
    for change, status, word in [
        ({"from": "nan"}, 422, "from"),
        ({"to": "inf"}, 422, "to"),
        ({"from": "yesterday"}, 422, "from"),
        ({"channels": []}, 422, "channels"),
        ({"channels": ["charm"]}, 422, "charm"),
        ({"channels": ["a;b"]}, 422, "channels"),
        ({"channels": ["energy"] * (CHANNELS_MAX + 1)}, 422, "channels"),
        ({"from": now + 1e6, "to": now + 2e6}, 404, "nothing is kept"),
    ]:
        refused = page.get("/api/history.csv", params=good | change)
        assert refused.status_code == status, change
        assert word in refused.text, change


def test_layouts_belong_to_one_browser(server: TestServer) -> None:
    mine, other = server.page().sign_in(), server.page().sign_in()
    assert mine.get("/api/layouts/tuning day (2)").status_code == 404
    assert mine.put("/api/layouts/tuning day (2)", json=LAYOUT).json() == LAYOUT
    assert mine.get("/api/layouts/tuning day (2)").json() == LAYOUT
    assert mine.get("/api/layouts").json() == ["tuning day (2)"]
    assert other.get("/api/layouts").json() == []
    assert mine.delete("/api/layouts/tuning day (2)").status_code == 204
    assert mine.get("/api/layouts").json() == []


@pytest.mark.parametrize(
    ("name", "body"),
    [
        ("x" * 41, LAYOUT),
        ("a;b", LAYOUT),
        ("ok", {"seconds": 4, "plots": []}),
        ("ok", {"seconds": 10, "plots": [{"title": "", "channels": ["a b"]}]}),
        ("ok", {"seconds": 10, "plots": [{"title": "", "channels": []}] * 9}),
        ("ok", {"seconds": 10, "plots": [], "colour": "red"}),
        ("ok", []),
    ],
)
def test_a_malformed_layout_is_refused(name: str, body: object, server: TestServer) -> None:
    page = server.page().sign_in()
    assert page.put(f"/api/layouts/{name}", json=body).status_code == 422
    assert page.get("/api/layouts").json() == []


def test_a_user_keeps_a_bounded_number_of_layouts_and_a_damaged_file_is_none(server: TestServer) -> None:
    page = server.page().sign_in()
    for number in range(LAYOUTS_MAX):
        assert page.put(f"/api/layouts/{number}", json=LAYOUT).status_code == 200
    assert page.put("/api/layouts/more", json=LAYOUT).status_code == 409
    assert page.put("/api/layouts/0", json=LAYOUT).status_code == 200
    files, who = UserFiles(server.settings.state / "layouts", "the layout"), Identity("someone", "teal fern 11")
    layouts = Layouts(files)
    layouts.write(who, "a", PlotLayout.model_validate(LAYOUT))
    files._file(who).write_bytes(b"\xff{")
    assert layouts.names(who) == []


def test_the_newest_rows_are_in_the_next_bin_not_in_the_table_twice() -> None:
    history = filled(1000)
    history.add(rows(1000, 5))
    _, _, values = read(table(history, Window(0.9, 2.0, ["tick"])))
    assert np.array_equal(values[:, 1], np.arange(900, 1005))
