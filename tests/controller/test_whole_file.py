"""Files that are there whole or not at all."""

import os
import stat
import threading
from pathlib import Path

import pytest

from controller.whole_file import SHARED, write_whole


def test_a_file_is_the_users_alone_unless_it_is_to_be_shared(tmp_path: Path) -> None:
    write_whole(tmp_path / "secret", "x")
    write_whole(tmp_path / "shared", b"y", SHARED, lasting=False)
    assert stat.S_IMODE((tmp_path / "secret").stat().st_mode) == 0o600
    assert stat.S_IMODE((tmp_path / "shared").stat().st_mode) == SHARED & ~_umask()


def test_what_lasts_is_on_the_disk_before_it_takes_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The order is what counts: fsync of all of the draft, then the rename."""
    path, seen = tmp_path / "file", []
    path.write_text("old")
    monkeypatch.setattr(os, "fsync", lambda file: seen.append((os.fstat(file).st_size, path.read_text())))
    write_whole(path, "quite new", lasting=True)
    write_whole(path, "newest", lasting=False)
    assert (seen, path.read_text()) == ([(9, "old")], "newest")


def test_a_write_that_fails_leaves_the_old_file_and_no_draft(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    write_whole(path, "old")

    def full(file: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_whole(path, "new")
    assert ([*tmp_path.iterdir()], path.read_text()) == ([path], "old")


def test_writers_at_the_same_time_never_mix(tmp_path: Path) -> None:
    path, texts = tmp_path / "file", [letter * 100_000 for letter in "abcd"]

    def write(text: str) -> None:
        for _ in range(20):
            write_whole(path, text, lasting=False)

    threads = [threading.Thread(target=write, args=(text,)) for text in texts]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        if path.exists():
            assert path.read_text() in texts
    for thread in threads:
        thread.join()
    assert [*tmp_path.iterdir()] == [path]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
