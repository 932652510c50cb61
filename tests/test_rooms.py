"""Rooms stay small enough to be seen at a glance; the front end has its own check (frontend/rooms.js)."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES_MAX, LINES_MAX = 40, 400
"""A folder of so many files is a drawer; whether a smaller one is a room, people judge by looking."""
ROOMS_MAX = {"controller": 12, "recordings": 8, "server": 16}
"""What a newcomer can count."""


@pytest.mark.parametrize("package", ["controller", "recordings", "server"])
def test_no_folder_and_no_file_is_crowded(package: str) -> None:
    files = list((ROOT / package).rglob("*.py"))
    folders = {path.parent for path in files}
    assert crowded(folders, FILES_MAX) == {}
    long = {str(path): count for path in files if (count := len(path.read_text().splitlines())) > LINES_MAX}
    assert long == {}


@pytest.mark.parametrize("package", ROOMS_MAX)
def test_rooms_can_be_counted(package: str) -> None:
    rooms = [path.parent.name for path in (ROOT / package).glob("*/__init__.py")]
    assert len(rooms) <= ROOMS_MAX[package], rooms


def test_no_folder_of_tests_is_crowded() -> None:
    assert crowded({path.parent for path in (ROOT / "tests").rglob("*.py")}, FILES_MAX) == {}


@pytest.mark.parametrize("package", ["controller", "recordings", "server"])
def test_the_tests_of_a_room_lie_in_a_room_of_its_name(package: str) -> None:
    rooms = {path.parent.relative_to(ROOT / "tests") for path in (ROOT / "tests" / package).rglob("test_*.py")}
    assert [str(room) for room in rooms if not (ROOT / room).is_dir()] == []


def crowded(folders: set[Path], most: int) -> dict[str, int]:
    """Those of `folders` that have more Python files than `most`."""
    return {str(one): count for one in folders if (count := len(list(one.glob("*.py")))) > most}
