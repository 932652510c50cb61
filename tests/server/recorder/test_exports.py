"""Recordings exported, followed again and imported over REST."""

import asyncio
import io
import json
import os
import shutil
import tempfile
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pandas as pd
import pytest
from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning
from starlette.requests import Request

from controller.errors import CommandRefused, RecordingError
from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.exporting import export as export_module
from recordings.exporting.export import By
from recordings.exporting.table import Choice, RowReader
from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from server.drawing.messages import DrawingBody
from server.drawing.recorded import drawing_name
from server.recorder import export_routes
from server.recorder.exports import Exports
from server.recorder.folder import Reader, RecordingsFolder
from tests.recordings.synthetic import batches, recorded, rig_info, telemetry_rows
from tests.server.live_server import Page, TestServer, rigless, wait_for

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

ROWS = telemetry_rows(6500)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestServer]:
    """A server that no rig has ever spoken to: recordings need none."""
    yield from rigless(tmp_path_factory.mktemp("server"))


@pytest.fixture(scope="module")
def done(server: TestServer) -> Recording:
    folder = server.settings.recordings
    assert folder is not None
    return recorded(folder, "Circle/0.5 Hz, ü", ROWS)


@pytest.fixture
def page(server: TestServer) -> Page:
    return server.page().sign_in()


def test_a_choice_in_a_window_comes_as_a_file_with_a_good_name(page: Page, done: Recording) -> None:
    asked = {"format": "csv", "signals": "tick, p_meas", "from": 1.0, "to": 2.0}
    answer = page.get(f"/api/recordings/{done.id}/export", params=asked)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-disposition"] == f'attachment; filename="{done.id}.csv"'
    found = pd.read_csv(io.StringIO(answer.text))
    assert [*found] == ["t [s]", "tick", "p_meas_x [m]", "p_meas_y [m]"]
    rows = ROWS[found["tick"]]
    assert 990 < len(found) < 1010 and (np.diff(found["tick"]) == 1).all()
    np.testing.assert_array_equal(found["p_meas_x [m]"], rows["p_meas"][:, 0])


def test_the_export_leaves_nothing_behind(
    page: Page, done: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert page.get(f"/api/recordings/{done.id}/export", params={"format": "rrd"}).status_code == 200
    assert page.get(f"/api/recordings/{done.id}/export", params={"format": "mat", "signals": "x"}).status_code == 422
    assert [*tmp_path.iterdir()] == []


@pytest.fixture
def running(server: TestServer) -> Iterator[str]:
    """Id of a recording that the server's own recorder is writing, with 6500 rows at first and more all the time."""
    recorder, ended = wait_for(lambda: getattr(server, "recorder", None), "the recorder"), threading.Event()
    id = recorder.start("running", rig_info(), Settings()).id

    def write() -> None:
        for batch in batches(telemetry_rows(60_000), 130):
            recorder.rows(batch)
            if batch["tick"][0] >= len(ROWS) and ended.wait(0.1):
                return

    writer = threading.Thread(target=write)
    writer.start()
    path = server.services.folder.store.path(id)
    wait_for(lambda: len(read_rows(path, ("tick",))["tick"]) >= len(ROWS), "rows in the file")
    yield id
    ended.set()
    writer.join()
    recorder.stop()


def test_of_what_is_being_written_all_that_is_there_is_exported(page: Page, running: str, tmp_path: Path) -> None:
    wanted = {"signals": "tick,p_meas,backbone"}
    csv = page.get(f"/api/recordings/{running}/export", params={"format": "csv", **wanted})
    parquet = page.get(f"/api/recordings/{running}/export", params={"format": "parquet", **wanted})
    for found in (pd.read_csv(io.BytesIO(csv.content)), pd.read_parquet(io.BytesIO(parquet.content))):
        assert len(found) >= len(ROWS) and (found["tick"] == np.arange(len(found))).all()
        tip = next(name for name in found if name.startswith("p_meas_x"))
        np.testing.assert_array_equal(found[tip], telemetry_rows(len(found))["p_meas"][:, 0])
    for url, asked in (("export", {"format": "rrd"}), ("rrd", {})):
        file = tmp_path / f"{url}.rrd"
        answer = page.get(f"/api/recordings/{running}{'.' if url == 'rrd' else '/'}{url}", params=asked)
        assert answer.status_code == 200
        file.write_bytes(answer.content)
        with pytest.warns(RerunWarning, match="no footer"):
            chunks = [*RrdReader(file).stream().filter(content=["/state"], has_timeline="tick")]
        ticks = np.concatenate([chunk.to_record_batch().column("tick").to_numpy() for chunk in chunks])
        assert len(ticks) >= len(ROWS) and (np.sort(ticks) == np.arange(len(ticks))).all()


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"format": "xls"}, "format"),
        ({"format": "csv", "signals": "u,zz"}, "signals = zz: this recording has no such signal"),
        ({"format": "csv", "from": "9"}, "from = 9 s is outside the recording's [0, 6.5"),
        ({"format": "csv", "to": "inf"}, "to"),
        ({"format": "rrd", "from": "1"}, "format = rrd is the whole file"),
    ],
)
def test_what_cannot_be_exported_is_named(page: Page, done: Recording, asked: dict[str, str], told: str) -> None:
    answer = page.get(f"/api/recordings/{done.id}/export", params=asked)
    assert answer.status_code == 422 and told in answer.text


def die(*arguments: object) -> None:
    """An export that the system kills, as for want of memory."""
    os._exit(1)


def test_an_export_that_is_killed_says_what_helps(page: Page, done: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(export_routes, "export", die)
        refused = page.get(f"/api/recordings/{done.id}/export", params={"format": "csv"})
    assert refused.json()["detail"] == "the export was killed, perhaps for want of memory: choose fewer signals"
    assert page.get(f"/api/recordings/{done.id}/export", params={"format": "csv"}).status_code == 200


def test_who_reads_recordings_stands_back_for_everything_else() -> None:
    reader = Reader()
    assert reader.call(os.nice, 0) == 19
    reader.stop()


@pytest.mark.parametrize("what", ["export?format=csv", "signals", "path"])
def test_unknown_recordings_are_not_found_and_strangers_get_nothing(server: TestServer, page: Page, what: str) -> None:
    for id in ("20200101-000000", "nothing", "..%2F..%2Fsecrets"):
        assert page.get(f"/api/recordings/{id}/{what}").status_code == 404
    assert server.page().get(f"/api/recordings/20200101-000000/{what}").status_code == 401


def test_the_signals_on_offer_are_those_that_can_be_exported(page: Page, done: Recording) -> None:
    offered = page.get(f"/api/recordings/{done.id}/signals").json()
    asked = {"format": "csv", "to": 0.01}
    text = page.get(f"/api/recordings/{done.id}/export", params=asked).text
    assert [one["name"] for one in offered] == [title.split(" ")[0] for title in text.splitlines()[0].split(",")[1:]]


def test_a_recorded_tip_comes_back_as_a_drawing_with_its_times(page: Page, done: Recording) -> None:
    drawn = DrawingBody.model_validate(page.get(f"/api/recordings/{done.id}/path").json())
    assert (drawn.name, drawn.timing.kind, len(drawn.points)) == ("Circle 0.5 Hz", "given", 5000)
    assert drawn.times is not None and drawn.times[-1] == pytest.approx(done.seconds, abs=1e-6)
    np.testing.assert_allclose(drawn.points[-1], ROWS["p_meas"][-1], atol=1e-6)
    asked = {"what": "marker", "rod": 5, "from": 1, "to": 1.5}
    marker = DrawingBody.model_validate(page.get(f"/api/recordings/{done.id}/path", params=asked).json())
    assert len(marker.points) == pytest.approx(50, abs=1)
    assert np.abs(ROWS["markers"][1000:1500, 4] - marker.points[3]).sum(axis=1).min() < 2e-6
    unseen = page.get(f"/api/recordings/{done.id}/path", params={"what": "marker", "rod": 4})
    assert unseen.status_code == 422 and "markers_4: it was seen at 0 times" in unseen.text


def test_another_labs_file_is_imported_listed_and_exported(server: TestServer) -> None:
    page = server.page().sign_in()
    asked = {"name": "Their circle", "length_unit": "mm"}
    text = b"time;x;y\n0;100,5;2\n0,5;101;3\n1;102;4\n"
    assert page.post("/api/recordings/import", params=asked, content=text).status_code == 403
    page.operate()
    answer = page.post("/api/recordings/import", params=asked, content=text)
    assert answer.status_code == 200, answer.text
    id = answer.json()["id"]
    assert any(one["id"] == id and one["imported"] for one in page.get("/api/recordings").json())
    exported = page.get(f"/api/recordings/{id}/export", params={"format": "csv", "signals": "p_meas"}).text
    wanted = [(0, 0.1005, 0.002), (0.5, 0.101, 0.003), (1, 0.102, 0.004)]
    np.testing.assert_allclose(np.loadtxt(io.StringIO(exported), delimiter=",", skiprows=1), wanted, atol=1e-15)
    page.operate()  # a slow machine may have taken longer than a lease without a sign of life
    wrong = page.post("/api/recordings/import", params=asked, content=b"t,x,y\n0,1,2\n1,a,2\n")
    assert (wrong.status_code, wrong.json()["detail"]) == (422, "the file, line 3: x = 'a' is not a number")


@pytest.mark.parametrize(
    ("name", "drawn"),
    [("a/b.csv", "a b"), ("ü", "recorded"), ("  x  ", "x"), ("-.-", "recorded"), ("n" * 99, "n" * 80)],
)
def test_any_name_makes_one_that_a_drawing_may_have(name: str, drawn: str) -> None:
    assert drawing_name(name) == drawn


def test_an_export_is_made_first_and_fetched_once_by_its_key(page: Page, done: Recording) -> None:
    body = {"format": "csv", "signals": ["tick", "p_meas"], "start": 1.0, "stop": 2.0}
    made = page.post(f"/api/recordings/{done.id}/exports", json=body)
    assert made.status_code == 200, made.text
    found = page.get(f"/api/exports/{made.json()['key']}")
    assert found.headers["content-disposition"] == f'attachment; filename="{done.id}.csv"'
    assert len(found.content) == made.json()["bytes"]
    asked = {"format": "csv", "signals": "tick,p_meas", "from": 1.0, "to": 2.0}
    assert found.content == page.get(f"/api/recordings/{done.id}/export", params=asked).content
    assert page.get(f"/api/exports/{made.json()['key']}").status_code == 404
    wrong = page.post(f"/api/recordings/{done.id}/exports", json=body | {"signals": ["nonsense"]})
    assert (wrong.status_code, "nonsense" in wrong.json()["detail"]) == (422, True)


def test_a_csv_file_says_by_both_doors_where_it_comes_from_if_asked(page: Page, done: Recording) -> None:
    asked = {"format": "csv", "signals": "tick", "from": 1.0, "to": 1.1}
    plain, commented = (
        page.get(f"/api/recordings/{done.id}/export", params=asked | {"comments": on}).text for on in (False, True)
    )
    lines = commented.splitlines()
    about = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    assert json.loads(about["files"]).keys() == {f"{done.id}.rrd"} and "actuators" in about
    assert [line for line in lines if not line.startswith("#")] == plain.splitlines()
    body = {"format": "csv", "signals": ["tick"], "start": 1.0, "stop": 1.1, "comments": True}
    made = page.post(f"/api/recordings/{done.id}/exports", json=body).json()
    dated = [line for line in page.get(f"/api/exports/{made['key']}").text.splitlines() if line[:7] != "# date:"]
    assert dated == [line for line in lines if line[:7] != "# date:"]


def test_who_hangs_up_cancels_the_export_and_nothing_of_it_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    targets: list[Path] = []

    async def never(_: object, __: Path, target: Path, *rest: object) -> None:
        targets.append(target)
        await asyncio.Event().wait()

    async def gone() -> bool:
        return bool(targets)

    folder, request = SimpleNamespace(read=never), SimpleNamespace(is_disconnected=gone)
    make = Exports(Scheduler()).make(
        cast(RecordingsFolder, folder), cast(Request, request), Path("run.rrd"), "csv", Choice(), By()
    )
    with pytest.raises(CommandRefused, match="cancelled"):
        asyncio.run(make)
    assert (targets[0].name, list(tmp_path.iterdir())) == ("run.csv", [])


def test_a_file_whose_folder_was_removed_is_written_no_further(
    done: Recording, server: TestServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, taken = tmp_path / "scratch" / "run.csv", 0
    target.parent.mkdir()

    def write(pieces: Iterable[object], *_: object) -> None:
        nonlocal taken
        for _piece in pieces:
            taken += 1
            shutil.rmtree(target.parent)

    monkeypatch.setattr(export_module, "_writer", lambda _: write)
    monkeypatch.setattr(RowReader, "pieces", lambda *_: iter(range(3)))
    with pytest.raises(RecordingError, match="cancelled"):
        export_module.export(Path("run.rrd"), target, "csv", Choice())
    assert taken == 1
