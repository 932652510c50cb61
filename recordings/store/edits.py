"""What people may change of a recording, and of its bookmarks."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.errors import RecordingError, spelled
from controller.schema.layout import Model
from recordings.format.messages import Bookmark, Label, Recording

Tag = Annotated[str, spelled(r"^[\w.-]{1,40}$", "a tag has 1 to 40 letters, digits and _ . -, no blanks")]
"""Letters, digits, - _ and the dot."""


class Edit(Model):
    """Body of PATCH /api/recordings/{id}; null leaves a field as it is."""

    name: Annotated[str, Bounds(min_length=1, max_length=80)] | None = None
    tags: Annotated[tuple[Tag, ...], Bounds(max_length=20)] | None = None
    notes: Annotated[str, Bounds(max_length=4000)] | None = None
    starred: bool | None = None

    def changes(self) -> dict[str, object]:
        """The fields that are to change, each tag once."""
        found = {name: value for name, value in self if value is not None}
        return found | ({"tags": tuple(dict.fromkeys(self.tags))} if self.tags is not None else {})


class BookmarkLabel(Model):
    """Body of the requests that set or name a bookmark."""

    label: Label = ""


def with_bookmark(found: Recording, mark: Bookmark) -> Recording:
    """`found` with one bookmark more."""
    return _bookmarked(found, (*found.bookmarks, mark))


def with_label(found: Recording, n: int, label: str) -> Recording:
    """`found` with another label on its bookmark `n`; RecordingError when there is none."""
    _require(found, n)
    marks = (mark.model_copy(update={"label": label}) if mark.n == n else mark for mark in found.bookmarks)
    return _bookmarked(found, tuple(marks))


def without_bookmark(found: Recording, n: int) -> Recording:
    """`found` without its bookmark `n`; RecordingError when there is none."""
    _require(found, n)
    return _bookmarked(found, tuple(mark for mark in found.bookmarks if mark.n != n))


def _require(found: Recording, n: int) -> None:
    if n not in (mark.n for mark in found.bookmarks):
        raise RecordingError(f"recording {found.id!r} has no bookmark {n}")


def _bookmarked(found: Recording, marks: tuple[Bookmark, ...]) -> Recording:
    return found.model_copy(update={"bookmarks": tuple(sorted(marks, key=lambda mark: (mark.t, mark.n)))})
