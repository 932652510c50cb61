"""Files that cannot be written are refused before the work."""

import os
from pathlib import Path

import pytest

from controller.errors import TendrilError
from server.cli.files import made, require_file, write


def test_what_cannot_be_written_is_said_before_and_after(tmp_path: Path) -> None:
    for path, complaint in ((tmp_path, "it is a folder"), (tmp_path / "no" / "a.json", "its folder does not exist")):
        with pytest.raises(TendrilError, match=f"{path} cannot be written: {complaint}"):
            require_file(path)
        with pytest.raises(TendrilError, match="cannot be written"):
            write(path, "")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_or_a_file_without_permission_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.json").touch(0o400)
    tmp_path.chmod(0o500)
    for name in ("a.json", "b.json"):
        with pytest.raises(TendrilError, match=f"{name} cannot be written: permission denied"):
            require_file(tmp_path / name)
    tmp_path.chmod(0o700)


def test_text_is_written_as_utf_8_into_a_folder_that_is_made(tmp_path: Path) -> None:
    path = made(tmp_path / "a" / "b") / "c.txt"
    require_file(path)
    write(path, "22 \u00b5s")
    assert path.read_bytes() == b"22 \xc2\xb5s"
    with pytest.raises(TendrilError, match=r"c\.txt cannot be made: "):
        made(path)
