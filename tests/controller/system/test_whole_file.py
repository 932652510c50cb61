"""Files that are there whole or not at all."""

import os
import stat
import threading
from pathlib import Path

import pytest

from controller.system.whole_file import (
    NotRegular,
    is_regular,
    open_append,
    open_lock,
    open_regular,
    read_whole,
    set_aside,
    write_new,
    write_whole,
)


def test_a_file_is_the_users_alone(tmp_path: Path) -> None:
    write_whole(tmp_path / "secret", "x")
    assert stat.S_IMODE((tmp_path / "secret").stat().st_mode) == 0o600


def test_what_lasts_is_on_the_disk_before_it_takes_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The order is what counts: fsync of all of the draft, then the rename, then fsync of the folder."""
    path, seen = tmp_path / "file", []
    path.write_text("old")

    def note(file: int) -> None:
        about = os.fstat(file)
        seen.append(("folder" if stat.S_ISDIR(about.st_mode) else about.st_size, path.read_text()))

    monkeypatch.setattr(os, "fsync", note)
    write_whole(path, "quite new", lasting=True)
    write_whole(path, "newest", lasting=False)
    assert (seen, path.read_text()) == ([(9, "old"), ("folder", "quite new")], "newest")


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


ODD = ("folder", "pipe", "link out", "link in", "loop", "dangling")


def make_odd(kind: str, path: Path, outside: Path) -> None:
    """Something at `path` that is no regular file; `outside` is a file elsewhere."""
    match kind:
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "link out":
            path.symlink_to(outside)
        case "link in":
            path.with_name("beside").write_text("beside")
            path.symlink_to("beside")
        case "loop":
            path.symlink_to(path.name)
        case "dangling":
            path.symlink_to("nothing")


@pytest.mark.parametrize("kind", ODD)
def test_only_a_regular_file_is_opened_and_nothing_waits_for_a_pipe(kind: str, tmp_path: Path) -> None:
    outside, path = tmp_path / "outside", tmp_path / "folder" / "file"
    path.parent.mkdir()
    outside.write_text("of someone else")
    make_odd(kind, path, outside)
    for work in (open_regular, open_append, open_lock, read_whole):
        with pytest.raises(NotRegular, match="not a regular file"):
            work(path)
    assert not is_regular(path)
    if kind != "folder":
        write_whole(path, "ours")
        assert (path.read_text(), outside.read_text()) == ("ours", "of someone else")
    else:
        aside = set_aside(path)
        assert aside is not None and aside.is_dir() and not path.exists()


def test_what_is_too_long_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(bytes(11))
    assert read_whole(tmp_path / "file", 11) == bytes(11)
    with pytest.raises(OSError, match="more than 10 bytes"):
        read_whole(tmp_path / "file", 10)


def test_one_of_many_makes_a_new_file_and_the_others_leave_it_alone(tmp_path: Path) -> None:
    made = []

    def make(letter: str) -> None:
        try:
            write_new(tmp_path / "file", letter.encode() * 1000)
            made.append(letter)
        except FileExistsError:
            pass

    threads = [threading.Thread(target=make, args=(letter,)) for letter in "abcdefgh"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [*tmp_path.iterdir()] == [tmp_path / "file"]
    assert [(tmp_path / "file").read_text()] == [letter * 1000 for letter in made]
