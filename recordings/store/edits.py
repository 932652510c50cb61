"""What people may change of a recording."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.spelled import spelled

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
