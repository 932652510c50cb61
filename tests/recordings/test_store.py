"""The list of recordings, and ids that come from the network."""

import builtins
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import RecordingError
from recordings import sidecar
from recordings.messages import Recording
from recordings.reader import read_rows
from recordings.store import Store
from tests.recordings.synthetic import telemetry_rows

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


def test_damaged_and_foreign_files_are_left_out_of_the_list(tmp_path: Path) -> None:
    store = Store(tmp_path)
    sidecar.write(tmp_path, _recording(1))
    (tmp_path / f"{_recording(2).id}.json").write_text("{")
    (tmp_path / f"{_recording(3).id}.json").write_text(_recording(4).model_dump_json())
    (tmp_path / "notes.json").write_text("{}")
    assert store.list() == [_recording(1)]


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
    for ask in (store.find, store.path, store.repair, store.compact):
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
