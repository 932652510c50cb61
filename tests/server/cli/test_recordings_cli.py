"""`tendril recordings` at the command line, on a folder without a server."""

import json
import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from controller.errors import CommandRefused, DataError, ParameterError, RecordingError, TendrilError
from controller.reference.path_file import read_samples
from controller.schema.origin import Origin
from controller.schema.parameters import Settings
from recordings.format import sidecar
from recordings.format.messages import Metrics, Recording
from recordings.store.catalogue import STALE_MAX
from recordings.store.comparing import apart
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.cli.main import app
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

ROWS = telemetry_rows(2000)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Recording]:
    folder = tmp_path_factory.mktemp("recordings")
    recorder = Recorder(folder)
    recorder.start("Circle [red]", rig_info(), Settings())
    for batch in batches(ROWS, 250):
        recorder.rows(batch)
    done = recorder.stop().model_copy(update={"tags": ("paper",), "metrics": Metrics(rmse=0.00321, lost=1)})
    recorder.close()
    sidecar.write(folder, done)
    return folder, done


def run(folder: Path, *arguments: object, answer: str = "", width: int = 200) -> str:
    """What the command prints; its error, if it has one."""
    words = ["recordings", *map(str, arguments), "--folder", str(folder)]
    result = CliRunner(env={"COLUMNS": str(width)}).invoke(app, words, input=answer)
    if isinstance(result.exception, TendrilError):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_list_is_searched_by_words_and_reads_well(made: tuple[Path, Recording]) -> None:
    folder, done = made
    (line,) = [line for line in run(folder, "ls", "PAPER", "circle").splitlines() if done.id in line]
    assert "Circle [red]" in line and "3.21" in line and "2.0" in line
    assert [one["id"] for one in json.loads(run(folder, "ls", "--json"))] == [done.id]
    assert json.loads(run(folder, "ls", "square", "--json")) == []


def test_the_list_fits_80_columns_with_every_id_and_figure_whole(tmp_path: Path) -> None:
    one = Recording(
        id="20261124-221007-2",
        name="A name that would fill a line by itself, and then some, and then some more",
        started=datetime.now(UTC),
        seconds=3612.3,
        rows=3612300,
        gaps=12,
        bytes=1_960_400_000,
        actuator="P1",
        twin=True,
        complete=True,
        recovered=True,
        starred=True,
        metrics=Metrics(rmse=0.0123),
    )
    sidecar.write(tmp_path, one)
    lines = run(tmp_path, "ls", width=80).splitlines()
    assert max(map(len, lines)) <= 80
    assert all(text in lines[2] for text in (one.id, "A name", "3612.3 s", "1960.4 MB", "12.3 mm", "12", "starred"))
    assert "recovered" in "".join(lines)


def test_a_list_writes_nothing(made: tuple[Path, Recording], tmp_path: Path) -> None:
    for number in range(STALE_MAX + 1):
        sidecar.write(tmp_path, made[1].model_copy(update={"id": f"20200101-{number:06}"}))
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path, *tmp_path.iterdir())}
    assert f"{STALE_MAX + 1} recordings" in run(tmp_path, "ls", "--limit", 99)
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path, *tmp_path.iterdir())} == before


def test_one_recording_is_shown_with_its_figures(made: tuple[Path, Recording]) -> None:
    folder, done = made
    text = run(folder, "show", done.id)
    assert "2000 rows" in text and "RMSE [mm]" in text and "3.21" in text
    shown = json.loads(run(folder, "show", done.id, "--json"))
    origin = Origin.model_validate(shown.pop("origin"))
    assert Recording.model_validate(shown) == done
    assert (origin.recorded_by[:8], [*origin.files]) == ("Tendril ", [f"{done.id}.rrd"])
    with pytest.raises(RecordingError, match="there is no recording '20200101-000000'"):
        run(folder, "show", "20200101-000000")


def test_numbers_and_paths_are_written_where_they_are_wanted(made: tuple[Path, Recording], tmp_path: Path) -> None:
    folder, done = made
    table, path = tmp_path / "some.csv", tmp_path / "path.csv"
    run(folder, "export", done.id, "--out", table, "--signals", "tick,u", "--from", 0.5, "--to", 1)
    assert table.read_text().splitlines()[0] == "t [s],tick,u_1 [N m],u_2 [N m]"
    run(folder, "export", done.id, "--format", "path", "--what", "p_ref", "--out", path)
    np.testing.assert_allclose(read_samples(path).p, ROWS["p_ref"], atol=1e-9)
    with pytest.raises(ParameterError, match="signals = zz"):
        run(folder, "export", done.id, "--signals", "zz", "--out", tmp_path / "none.csv")
    with pytest.raises(RecordingError, match="is the recording itself"):
        run(folder, "export", done.id, "--format", "rrd", "--out", folder / f"{done.id}.rrd")


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        (["--format", "path", "--signals", "p_ref"], "--signals p_ref: --format path holds t, x, y"),
        (["--what", "p_ref"], "--what p_ref: is for --format path, not csv"),
        (["--format", "mat", "--rod", 3], "--rod 3: is for --format path, not mat"),
        (["--format", "path", "--rod", 10], "--rod 10: is for --what marker, not p_meas"),
        (["--format", "parquet", "--comments"], "--comments: is for --format csv and path; parquet says its origin"),
        (["--format", "rrd", "--comments"], "--comments: is for --format csv and path; rrd is the recording"),
    ],
)
def test_an_option_that_a_format_does_not_hear_is_refused(
    made: tuple[Path, Recording], tmp_path: Path, given: list[object], complaint: str
) -> None:
    folder, done = made
    with pytest.raises(ParameterError, match=complaint):
        run(folder, "export", done.id, *given, "--out", tmp_path / "out")
    assert [*tmp_path.iterdir()] == []
    run(folder, "export", done.id, "--format", "path", "--what", "marker", "--rod", 5, "--out", tmp_path / "marker.csv")


def test_another_labs_path_is_imported_and_held_against_ours(made: tuple[Path, Recording], tmp_path: Path) -> None:
    folder, done = made
    t = (ROWS["t_ns"] - ROWS["t_ns"][0])[::40] * 1e-9
    lines = [f"{at},{1e3 * x + 3},{1e3 * y + 4}" for at, (x, y) in zip(t, ROWS["p_meas"][::40], strict=True)]
    file = tmp_path / "lab.csv"
    file.write_text("\n".join(["time,x,y", *lines]))
    run(folder, "import", file, "--length-unit", "mm")
    (theirs,) = [one for one in Store(folder).list() if one.imported]
    assert theirs.name == "lab"
    found = json.loads(run(folder, "compare", done.id, theirs.id, "--json"))
    assert set(Origin.model_validate(found.pop("origin")).files) == {f"{one.id}.rrd" for one in (done, theirs)}
    assert set(found) == {done.id, theirs.id}
    assert found[done.id]["rmse"] == 0.00321 and found[done.id]["apart_max"] == 0.0
    assert found[theirs.id]["apart_rms"] == pytest.approx(0.005, abs=1e-6)
    table = run(folder, "compare", done.id, theirs.id)
    assert "5.00" in table and "SSE" not in table
    with pytest.raises(RecordingError, match="1 recordings cannot be compared: give 2 to 4"):
        run(folder, "compare", done.id)
    file.write_text("t,x,y\n0,0,0\n0,0,0\n")
    with pytest.raises(DataError, match="line 3: t = 0 s is not after"):
        run(folder, "import", file)


def test_paths_are_compared_along_straight_lines_at_common_times() -> None:
    first = np.array([0.0, 1.0]), np.array([(0.0, 0.0), (2.0, 0.0)])
    other = np.array([0.5, 1.0, 1.5]), np.array([(1.0, 3.0), (2.0, 4.0), (9.0, 9.0)])
    assert apart(first, other) == {"apart_rms": pytest.approx(12.5**0.5), "apart_max": 4.0}
    assert apart(first, (np.array([2.0]), np.zeros((1, 2)))) == {"apart_rms": None, "apart_max": None}


def test_what_is_deleted_is_asked_for_and_a_star_protects(made: tuple[Path, Recording], tmp_path: Path) -> None:
    _, done = made
    for id, starred in ((done.id, False), ("20200101-000000", True)):
        (tmp_path / f"{id}.rrd").write_bytes(b"x")
        sidecar.write(tmp_path, done.model_copy(update={"id": id, "starred": starred}))
    with pytest.raises(CommandRefused, match="is starred"):
        run(tmp_path, "rm", done.id, "20200101-000000", "--yes")
    run(tmp_path, "rm", done.id, answer="n\n")
    assert len(Store(tmp_path).list()) == 2
    held = sidecar.lock(tmp_path / f"{done.id}.rrd")
    assert held
    with held, pytest.raises(CommandRefused, match="is still being written"):
        run(tmp_path, "rm", done.id, "--yes")
    run(tmp_path, "rm", done.id, answer="y\n")
    assert sorted(path.name for path in tmp_path.glob("[!.]*")) == ["20200101-000000.json", "20200101-000000.rrd"]


@pytest.mark.process
def test_what_a_killed_writer_left_is_mended(made: tuple[Path, Recording], tmp_path: Path) -> None:
    folder, done = made
    (tmp_path / f"{done.id}.rrd").write_bytes((folder / f"{done.id}.rrd").read_bytes()[:-1000])
    sidecar.write(tmp_path, done.model_copy(update={"complete": False}))
    assert f"{done.id}: mended, " in run(tmp_path, "repair")
    assert Store(tmp_path).find(done.id).recovered


@pytest.mark.process
def test_what_cannot_be_mended_is_named_and_keeps_no_other_from_it(
    made: tuple[Path, Recording], tmp_path: Path
) -> None:
    folder, done = made
    bad = ("20200101-000000", "20990101-000000")  # one is met before the good one and one after it
    for id in bad:
        (tmp_path / f"{id}.rrd").write_bytes(b"")
        sidecar.write(tmp_path, done.model_copy(update={"id": id, "complete": False}))
    (tmp_path / f"{done.id}.rrd").write_bytes((folder / f"{done.id}.rrd").read_bytes()[:-1000])
    sidecar.write(tmp_path, done.model_copy(update={"complete": False}))
    with pytest.raises(RecordingError) as refused:
        run(tmp_path, "repair")
    assert "2 of 3 recordings are not mended" in str(refused.value) and all(
        f"{id}: " in str(refused.value) for id in bad
    )
    assert Store(tmp_path).find(done.id).recovered
    with pytest.raises(RecordingError, match=r"1 of 1 .*20200101-000001: there is no recording"):
        run(tmp_path, "repair", "20200101-000001")


def test_a_damaged_recording_is_deleted_like_any_other(tmp_path: Path) -> None:
    for id, description in (("20200101-000000", "{"), ("20200101-000001", None)):
        (tmp_path / f"{id}.rrd").write_bytes(bytes(2_300_000))
        if description:
            (tmp_path / f"{id}.json").write_text(description)
        asked = run(tmp_path, "rm", id, answer="n\n")
        assert f"Delete {id}" in asked and "2.3 MB" in asked
        assert f"Deleted: {id}" in run(tmp_path, "rm", id, "--yes")
    assert Store(tmp_path).list() == []
    with pytest.raises(RecordingError, match="there is no recording '20200101-000002'"):
        run(tmp_path, "rm", "20200101-000002", "--yes")


def test_without_a_display_the_viewer_says_so(made: tuple[Path, Recording], monkeypatch: pytest.MonkeyPatch) -> None:
    folder, done = made
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(RecordingError, match="there is no display"):
        run(folder, "play", done.id)


def test_a_wrong_folder_is_named_and_not_made(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="is not a folder"):
        run(tmp_path / "typo", "ls")
    assert os.listdir(tmp_path) == []
