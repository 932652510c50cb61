"""Recordings are their owner's alone, whatever the umask of who records."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from controller.schema.parameters import Settings
from recordings.store.finishing import finish
from recordings.store.store import Store
from recordings.write.writer import Recorder
from tests.recordings.synthetic import rig_info, telemetry_rows


@pytest.fixture
def open_umask() -> Iterator[None]:
    before = os.umask(0)
    yield
    os.umask(before)


@pytest.mark.usefixtures("open_umask")
@pytest.mark.process
def test_folder_and_files_are_private_as_recorded_finished_and_deleted(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    recorder = Recorder(folder)
    ids = []
    for name in ("kept", "deleted"):
        ids.append(recorder.start(name, rig_info(), Settings()).id)
        recorder.rows(telemetry_rows(2000))
        recorder.stop()
    recorder.close()
    assert finish(folder, ids[0]) == ()
    Store(folder).remove(ids[1])
    Store(folder).clear_bin()
    found = {path: stat.S_IMODE(path.lstat().st_mode) for path in (folder, *folder.rglob("*"))}
    assert {path for path in found if path.is_dir()} == {folder, folder / ".deleted"}
    assert {path.name: oct(mode) for path, mode in found.items() if mode & 0o077} == {}
    assert len(found) > 6
