"""The list of recordings, and ids that come from the network."""

import builtins
import errno
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import CommandRefused, ParameterError, RecordingError
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from recordings.format import sidecar
from recordings.format.messages import Metrics, Recording
from recordings.read.query import COLUMNS, matching, ordered
from recordings.read.reader import read_rows
from recordings.store import catalogue
from recordings.store.edits import Edit
from recordings.store.store import Store
from recordings.write.writer import Recorder
from tests.recordings.synthetic import rig_info, telemetry_rows

START = datetime(2026, 11, 20, 12, 0, 0, tzinfo=UTC)


def test_a_long_list_is_read_newest_first_without_opening_any_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store(tmp_path)
    for n in range(1000):
        sidecar.write(tmp_path, _recording(n))
        (tmp_path / f"{_recording(n).id}.rrd").write_bytes(b"not even rerun data")
    opened: list[str] = []
    real = builtins.open

    def spy(file: Any, *arguments: Any, **options: Any) -> Any:
        opened.append(str(file))
        return real(file, *arguments, **options)

    monkeypatch.setattr(builtins, "open", spy)
    monkeypatch.setattr("io.open", spy)
    listed = store.list()
    assert [recording.rows for recording in listed] == list(range(999, -1, -1))
    assert len(opened) >= 1000
    assert not [name for name in opened if name.endswith(".rrd")]


def test_what_is_damaged_is_listed_as_such_and_what_is_foreign_is_not(tmp_path: Path) -> None:
    store = Store(tmp_path)
    for n in (1, 2, 3, 6):
        (tmp_path / f"{_recording(n).id}.rrd").touch()
    sidecar.write(tmp_path, _recording(1))
    (tmp_path / f"{_recording(2).id}.json").write_text("{")
    (tmp_path / f"{_recording(3).id}.json").write_text(_recording(4).model_dump_json())
    sidecar.write(tmp_path, _recording(5))
    (tmp_path / "99999999-999999.rrd").touch()
    (tmp_path / "notes.json").write_text("{}")
    (tmp_path / "notes.rrd").write_text("{}")
    listed = {recording.id: recording for recording in store.list()}
    assert listed.pop(_recording(1).id) == _recording(1)
    problems = {id: recording.problem for id, recording in listed.items()}
    assert problems.keys() == {*(_recording(n).id for n in (2, 3, 5, 6)), "99999999-999999"}
    assert "cannot be read" in problems[_recording(2).id]
    assert _recording(4).id in problems[_recording(3).id]
    assert problems[_recording(5).id] == "its data is missing"
    assert problems[_recording(6).id] == "its description is missing"
    assert listed[_recording(6).id].started == _recording(6).started


def test_a_second_list_reads_only_what_has_changed_even_after_a_restart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for n in range(100):
        sidecar.write(tmp_path, _recording(n))
        (tmp_path / f"{_recording(n).id}.rrd").touch()
    first = Store(tmp_path).list()
    read: list[str] = []
    real = sidecar.read
    monkeypatch.setattr(sidecar, "read", lambda folder, id: read.append(id) or real(folder, id))
    assert Store(tmp_path).list() == first
    assert read == []
    changed = _recording(7).model_copy(update={"name": "run X"})  # as long as before
    (tmp_path / f"{changed.id}.json").write_text(changed.model_dump_json(indent=1))
    (tmp_path / f"{_recording(8).id}.json").unlink()
    (tmp_path / f"{_recording(8).id}.rrd").unlink()
    listed = Store(tmp_path).list()
    assert read == [changed.id]
    assert listed == [changed if r.id == changed.id else r for r in first if r.id != _recording(8).id]


@pytest.mark.parametrize("index", [b"", b"{", b"\xff", b'{"a": 1}', b"[]"])
def test_a_damaged_index_costs_no_recording(tmp_path: Path, index: bytes) -> None:
    sidecar.write(tmp_path, _recording(1))
    (tmp_path / f"{_recording(1).id}.rrd").touch()
    (tmp_path / catalogue.INDEX).write_bytes(index)
    assert Store(tmp_path).list() == [_recording(1)]


def test_a_description_that_could_not_be_read_once_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where too many files are open, or a network folder stumbles; the index is written meanwhile."""
    monkeypatch.setattr(catalogue, "STALE_MAX", 0)
    for n in range(3):
        sidecar.write(tmp_path, _recording(n))
        (tmp_path / f"{_recording(n).id}.rrd").write_bytes(b"data")
    true, store = sidecar.read_whole, Store(tmp_path)

    def stumbles(path: Path, most: int) -> bytes:
        if path.stem == _recording(1).id:
            raise OSError(errno.EIO, "Input/output error", str(path))
        return true(path, most)

    with monkeypatch.context() as failing:
        failing.setattr(sidecar, "read_whole", stumbles)
        assert [one.id for one in store.list() if one.problem] == [_recording(1).id]
    for found in (store, Store(tmp_path)):
        assert not any(one.problem for one in found.list())
        assert found.list() == [_recording(n) for n in (2, 1, 0)]


def test_an_edit_outlives_what_the_writer_knows(tmp_path: Path) -> None:
    sidecar.write(tmp_path, _recording(1))
    edit = Edit(name="best", tags=("a", "b", "a"), notes="no leak", starred=True)
    edited = Store(tmp_path).edit(_recording(1).id, edit)
    assert (edited.name, edited.tags, edited.notes, edited.starred) == ("best", ("a", "b"), "no leak", True)
    sidecar.write(tmp_path, _recording(1).model_copy(update={"rows": 77, "tags": ("fault",)}))
    found = sidecar.read(tmp_path, edited.id)
    assert found == edited.model_copy(update={"rows": 77, "tags": ("a", "b", "fault")})
    assert not Store(tmp_path).edit(edited.id, Edit(starred=False)).starred


def test_a_star_taken_away_during_a_recording_stays_away(recorder: Recorder, tmp_path: Path) -> None:
    store = Store(tmp_path)
    id = recorder.start("x", rig_info(), Settings()).id
    recorder.rows(telemetry_rows(10))
    store.edit(id, Edit(starred=True, name="y"))
    store.edit(id, Edit(starred=False))
    done = recorder.stop()
    assert (done.starred, done.name) == (False, "y")
    assert store.find(id) == done


def test_edits_of_many_threads_and_a_writer_lose_nothing(tmp_path: Path) -> None:
    store, names = Store(tmp_path), ("name", "notes", "tags", "starred")
    sidecar.write(tmp_path, _recording(1))
    edits = [Edit(name="new"), Edit(notes="new"), Edit(tags=("new",)), Edit(starred=True)]

    def write(n: int) -> None:
        sidecar.write(tmp_path, _recording(1).model_copy(update={"rows": n}))

    with ThreadPoolExecutor(8) as pool:
        done = [pool.submit(store.edit, _recording(1).id, edit) for edit in edits]
        done += [pool.submit(write, n) for n in range(50)]
    for future in done:
        future.result()
    assert [getattr(store.find(_recording(1).id), name) for name in names] == ["new", "new", ("new",), True]


def test_a_starred_recording_and_one_being_written_are_not_removed(recorder: Recorder, tmp_path: Path) -> None:
    store = Store(tmp_path)
    id = recorder.start("x", rig_info(), Settings()).id
    with pytest.raises(CommandRefused, match="still being written"):
        store.remove(id)
    recorder.rows(telemetry_rows(10))
    recorder.stop()
    store.edit(id, Edit(starred=True))
    with pytest.raises(CommandRefused, match="starred"):
        store.remove(id)
    store.edit(id, Edit(starred=False))
    store.remove(id)
    assert store.list() == []
    with pytest.raises(RecordingError, match="there is no recording"):
        store.remove(id)


def test_a_damaged_recording_can_be_removed(tmp_path: Path) -> None:
    (tmp_path / f"{_recording(1).id}.rrd").touch()
    (tmp_path / f"{_recording(1).id}.json").write_text("{")
    sidecar.write(tmp_path, _recording(2))
    for n in (1, 2):
        Store(tmp_path).remove(_recording(n).id)
    assert Store(tmp_path).list() == []


@pytest.mark.process
def test_a_check_notes_damage_and_a_lost_description_is_made_again(
    record: Callable[..., Recording], tmp_path: Path
) -> None:
    done, store = record(telemetry_rows(2000)), Store(tmp_path)
    assert store.check(done.id).problem == ""
    (tmp_path / f"{done.id}.json").unlink()
    assert store.list()[0].problem == "its description is missing"
    found = store.repair(done.id)
    assert (found.rows, found.gaps, found.actuator, found.recovered) == (2000, 0, done.actuator, True)
    assert store.list()[0].problem == ""
    data = store.path(done.id)
    data.write_bytes(data.read_bytes()[:-2000] + bytes(2000))
    assert "verify failed" in store.check(done.id).problem
    assert store.list()[0].problem


def test_metrics_are_kept_and_tell_the_cycles(record: Callable[..., Recording], tmp_path: Path) -> None:
    rows = telemetry_rows(9000)
    rows["mode"] = Mode.TRACK
    store, id = Store(tmp_path), record(rows).id
    kept = store.measure(id).metrics
    assert kept is not None
    assert kept == store.find(id).metrics == store.list()[0].metrics
    e = rows["p_ref"] - rows["p_meas"]
    assert kept.rmse == pytest.approx(np.sqrt(np.mean(np.sum(e**2, axis=1))))
    assert kept.lag_deg_x == pytest.approx((0.03 + 0.0045) * 180, abs=0.05)  # and markers of 0..9 ms age
    assert kept.unsensed_rms is not None
    measured = store.measured(id)
    assert measured.whole == kept
    assert len(measured.cycles) == 4  # 9 s at 0.5 Hz


def test_search_wants_every_word_and_sort_puts_what_is_unknown_last() -> None:
    runs = [
        _recording(n).model_copy(update={"name": name, "notes": notes, "metrics": Metrics(rmse=rmse)})
        for n, (name, notes, rmse) in enumerate(
            [("Circle", "leak", 0.003), ("eight", "a LEAK", None), ("Eight", "", 0.001)]
        )
    ]
    assert [r.rows for r in matching(runs, "LEAK circ")] == [0]
    assert [r.rows for r in matching(runs, " eight ")] == [1, 2]
    assert matching(runs, "") == runs
    assert [r.rows for r in ordered(runs, "rmse")] == [2, 0, 1]
    assert [r.rows for r in ordered(runs, "-rmse")] == [0, 2, 1]
    assert [r.rows for r in ordered(runs, "-name")] == [1, 2, 0]
    for column in COLUMNS:
        assert len(ordered(runs, f"-{column}")) == 3
    with pytest.raises(ParameterError, match="'nothing' is none of"):
        ordered(runs, "nothing")


@pytest.mark.parametrize(
    "id",
    [
        "../secret",
        "..",
        "",
        "/etc/passwd",
        "20261120-120000/../../secret",
        "20261120-120000\x00",
        "20261120-120000\n",
        "20261120-120000.json",
        "20261120-12000\u0661",
        "20261120-120000-" + "a" * 200,
    ],
)
def test_an_id_that_tries_to_leave_the_folder_is_refused(tmp_path: Path, id: str) -> None:
    (tmp_path / "secret.rrd").write_bytes(b"secret")
    store = Store(tmp_path / "recordings")
    for ask in (store.find, store.path, store.repair, store.compact, store.check, store.measured, store.remove):
        with pytest.raises(RecordingError, match="is not the id of a recording"):
            ask(id)


def test_an_unknown_id_is_an_error_that_names_it(tmp_path: Path) -> None:
    store = Store(tmp_path)
    for ask in (store.find, store.path, store.repair):
        with pytest.raises(RecordingError, match="20261120-120000-nothing"):
            ask("20261120-120000-nothing")


@pytest.mark.parametrize("name", ["", "Kreis, 0,5 Hz (überlegt)", "../../etc", "\x00\n", "x" * 80, "a b " * 20])
def test_any_name_gives_an_id_of_our_form_and_never_the_same_twice(tmp_path: Path, name: str) -> None:
    ids = set()
    for _ in range(3):
        id, lock = sidecar.claim(tmp_path, name, START)
        lock.close()
        ids.add(sidecar.check_id(id))
    assert len(ids) == 3
    assert {path.stem for path in tmp_path.iterdir()} == ids


@pytest.mark.process
def test_a_compacted_recording_holds_the_same_rows(record: Callable[..., Recording], tmp_path: Path) -> None:
    rows = telemetry_rows(5000)
    done = record(rows)
    store = Store(tmp_path)
    before = read_rows(store.path(done.id))
    compacted = store.compact(done.id)
    after = read_rows(store.path(done.id))
    assert before.keys() == after.keys()
    for name, values in before.items():
        np.testing.assert_array_equal(after[name], values, err_msg=name)
    assert compacted == done.model_copy(update={"bytes": compacted.bytes})
    assert store.path(done.id).stat().st_size == compacted.bytes < done.bytes


def _recording(n: int) -> Recording:
    return Recording(
        id=(START + timedelta(seconds=n)).strftime("%Y%m%d-%H%M%S"),
        name=f"run {n}",
        started=START + timedelta(seconds=n),
        seconds=1.5,
        rows=n,
        gaps=0,
        bytes=19,
        actuator="P1",
        twin=True,
        complete=True,
    )
