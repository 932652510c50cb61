"""Rooms stay small enough to be seen at a glance; the front end has its own check (frontend/rooms.js)."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES_MAX, LINES_MAX = 16, 400


@pytest.mark.parametrize("package", ["controller", "recordings", "server"])
def test_no_folder_and_no_file_is_crowded(package: str) -> None:
    files = list((ROOT / package).rglob("*.py"))
    folders = {path.parent for path in files}
    crowded = {str(one): count for one in folders if (count := len(list(one.glob("*.py")))) > FILES_MAX}
    assert crowded == {}
    long = {str(path): count for path in files if (count := len(path.read_text().splitlines())) > LINES_MAX}
    assert long == {}
